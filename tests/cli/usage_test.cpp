// Tests the command line's contract: help, exit codes, and messages for bad usage and bad input.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "base/words.h"
#include "cli/command.h"
#include "experiment/child.h"

namespace rangegrasp {
namespace {

using testing::HasSubstr;
using testing_support::Command;
using testing_support::ExpectRefused;
using testing_support::Ran;
using testing_support::RunProgram;
using testing_support::TempFolder;

const std::filesystem::path kUsageSource = RANGEGRASP_SOURCE_DIR;
const std::string kTabletop = kUsageSource / "scenes/tabletop.xml";
const std::string kLaserSingle = kUsageSource / "experiments/laser_single.yaml";

const std::vector<std::string> kCommands = base::Split(
    "run table trial compare merge export report reproduce submit status snapshot view scan "
    "perceive check cylinders parts seam stereo calibrate-stereo calibrate-hand-eye add-object "
    "learn recognize bring list completion version",
    ' ');
// Commands that need no arguments.
const std::set<std::string> kNeedNothing = {"version", "list", "reproduce"};

// The names in the program's help.
std::vector<std::string> ListedCommands(const std::string& help) {
  const std::string title = "Subcommands:\n";
  std::istringstream lines(help.substr(help.find(title) + title.size()));
  std::vector<std::string> names;
  for (std::string line; std::getline(lines, line) && !line.empty();) {
    if (line[2] != ' ') names.push_back(line.substr(2, line.find(' ', 2) - 2));
  }
  return names;
}

TEST(Help, EveryCommandHasAnExampleOfItself) {
  for (const std::string& command : kCommands) {
    const Ran ran = RunProgram({command, "--help"});
    EXPECT_EQ(ran.code, 0) << command;
    EXPECT_EQ(ran.err, "") << command;
    EXPECT_THAT(ran.out, testing::ContainsRegex("Examples?:[ \n]+rangegrasp " + command));
  }
}

// An option without a description would be alone in its line, not followed by a description.
TEST(Help, EveryOptionSaysWhatItDoes) {
  auto commands = kCommands;
  for (const char* inner : {"detect", "calibrate", "generate"}) {
    commands.push_back(std::string("seam ") + inner);
  }
  constexpr std::size_t kDescriptions = 30;  // their first column
  for (const std::string& command : commands) {
    std::vector<std::string> arguments = base::Split(command, ' ');
    arguments.emplace_back("--help");
    std::istringstream help(RunProgram(arguments).out);
    int options = 0;
    std::string option;
    for (std::string line; std::getline(help, line);) {
      const bool goes_on = line.starts_with(std::string(kDescriptions, ' '));
      EXPECT_TRUE(option.empty() || goes_on) << command << ": " << option;
      option.clear();
      if (!line.starts_with("  -")) continue;
      ++options;
      if (line.size() <= kDescriptions || line[kDescriptions - 1] != ' ') option = line;
    }
    EXPECT_EQ(option, "") << command;
    EXPECT_GE(options, 1) << command;  // --help
  }
}

TEST(Help, TheProgramListsItsCommandsAndExitCodes) {
  const Ran ran = RunProgram({"--help"});
  EXPECT_EQ(ran.code, 0);
  EXPECT_THAT(ListedCommands(ran.out), testing::UnorderedElementsAreArray(kCommands));
  EXPECT_THAT(ran.out, HasSubstr("Exit codes"));
}

TEST(Usage, NoCommandOrAnUnknownOneIsRefused) {
  ExpectRefused({}, "subcommand");
  ExpectRefused({"fly"}, "fly");
  ExpectRefused({"tables"}, "did you mean 'table'?");
  EXPECT_THAT(RunProgram({"show"}).err, testing::Not(HasSubstr("did you mean")));
}

TEST(Usage, UnknownOptionsAndMissingArgumentsAreRefused) {
  for (const std::string& command : kCommands) {
    ExpectRefused({command, "--no-such-option"}, "");
    if (!kNeedNothing.contains(command)) ExpectRefused({command}, "");
  }
}

TEST(Usage, UnexpectedArgumentsAreNamedInTheirOrder) {
  ExpectRefused({"version", "one", "two", "--three"}, "unexpected: one two --three;");
}

TEST(Usage, OptionValuesOutOfRangeAreRefused) {
  const TempFolder folder;
  const std::string out = folder / "out";
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"run", kLaserSingle, "--out", out});
    return more;
  };
  ExpectRefused(with({"--trials", "0"}), "--trials");
  ExpectRefused(with({"--trials", "x"}), "--trials");
  ExpectRefused(with({"--jobs", "0"}), "--jobs");
  ExpectRefused(with({"--seed", "-1"}), "--seed");
  ExpectRefused(with({"--format", "xml"}), "--format");
  for (const char* shard : {"0/2", "3/2", "1", "a/b", "1/2x", "-1/2", ""}) {
    ExpectRefused(with({std::string("--shard=") + shard}), "--shard");
  }
  ExpectRefused(with({"--objects", "coffee_cap"}), "did you mean 'coffee_cup'");
  EXPECT_FALSE(std::filesystem::exists(out));
  for (const char* size : {"0x0", "100", "100x", "x100", "1x1", "99999x99999", "100x100x"}) {
    ExpectRefused({"snapshot", kTabletop, "-o", folder / "a.png", "--size", size}, size);
  }
}

TEST(Usage, SetTakesOneValueSoThatTheFileMayFollow) {
  for (const char* command : {"run", "check", "snapshot"}) {
    ExpectRefused({command, "--set", "seed=1", "--set", "stop_after=3", "none.yaml"}, "none.yaml");
  }
}

TEST(Usage, EachAssignmentNeedsItsOwnSet) {
  const std::string says = "unexpected 'stop_after=3': each KEY=VALUE needs its own --set";
  ExpectRefused({"run", kLaserSingle, "--set", "seed=1", "stop_after=3"}, says);
  ExpectRefused({"check", "--set=seed=1", "stop_after=3", kLaserSingle}, says);
}

TEST(Usage, AnAssignmentNeedsAnEqualSign) {
  const std::string says = "--set 'clutter.max_others': must be KEY=VALUE";
  const std::string cure = says + ": --set 'clutter.max_others=2'";
  ExpectRefused({"run", kLaserSingle, "--set", "clutter.max_others", "2"}, cure);
  ExpectRefused({"check", "--set=clutter.max_others", "2", kLaserSingle}, cure);
  ExpectRefused({"run", "--set", "clutter.max_others", kLaserSingle}, says + ", e.g. ");
}

TEST(Usage, AWarningSaysThatItIsOneOnce) {
  const Ran ran =
      RunProgram({"run", kLaserSingle, "--set", "clutter.max_others=2", "--objects", "none"});
  EXPECT_THAT(ran.err, testing::StartsWith("warning: --set clutter.max_others: key 'clutter."));
}

TEST(Usage, WholeNumbersAreDecimalAndFit) {
  const TempFolder folder;
  for (const char* option : {"--seed", "--trials", "--jobs"}) {
    for (const char* number : {"0x10", "18446744073709551616", "1.5", "-1", "+1"}) {
      ExpectRefused(
          {"run", kLaserSingle, "--out", folder / "out", std::string(option) + "=" + number},
          std::string(option) + ": '" + number + "' must be a whole number from ");
    }
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(Usage, LeadingZerosAreNotOctal) {
  const TempFolder folder;
  const auto drawn = [&](const std::string& seed) {
    const std::string file = folder / ("seed_" + seed + ".png");
    Succeeded(
        RunProgram({"snapshot", kLaserSingle, "-o", file, "--size", "64x64", "--seed", seed}));
    return base::ReadFile(file);
  };
  EXPECT_EQ(drawn("010"), drawn("10"));
  EXPECT_NE(drawn("010"), drawn("8"));
}

TEST(Usage, SetChangesTheExperimentOfAPictureOrScan) {
  const TempFolder folder;
  const auto drawn = [&](const std::string& option, const std::string& value) {
    const std::string file = folder / ("by" + option + ".png");
    Succeeded(RunProgram({"snapshot", kLaserSingle, "-o", file, "--size", "64x64", option, value}));
    return base::ReadFile(file);
  };
  EXPECT_EQ(drawn("--set", "seed=10"), drawn("--seed", "10"));
  ExpectRefused({"scan", kLaserSingle, "-o", folder / "a.pcd", "--set", "physics.step=1"},
                "unknown key 'step'");
  ExpectRefused({"snapshot", kTabletop, "-o", folder / "a.png", "--set", "seed=10"},
                "--set needs an experiment file");
}

TEST(Usage, ANumberThatIsNoneIsNotInARange) {
  ExpectRefused({"perceive", "cloud.pcd", "--noise-mm", "nan"},
                "--noise-mm: 'nan' must be a number from 0 to 50");
}

TEST(Usage, AFileOfAnotherKindThanCanBeWrittenIsRefused) {
  ExpectRefused({"scan", kTabletop, "-o", "s.xyz"},
                "s.xyz: unsupported file type; the name must end with .pcd or .ply");
  ExpectRefused({"snapshot", kTabletop, "-o", "s.jpg"},
                "s.jpg: unsupported file type; the name must end with .png");
}

// The refusal comes before the camera is calibrated, which takes much longer than this.
TEST(Usage, PicturesOfAScanNeedALineScanner) {
  const TempFolder folder;
  const std::string cloud = folder / "s.pcd";
  const std::vector<std::vector<std::string>> choices = {{"--target-only"},
                                                         {"--picture", folder / "s.png"}};
  for (const auto& choice : choices) {
    std::vector<std::string> arguments = {"scan", kLaserSingle, "--sensor", "stereo", "-o", cloud};
    arguments.insert(arguments.end(), choice.begin(), choice.end());
    ExpectRefused(arguments, "--picture and --target-only need a line scanner");
  }
  EXPECT_FALSE(std::filesystem::exists(cloud));
}

// No object is as slow as this so soon after its drop.
TEST(Usage, ASnapshotWithoutAnArrangementSaysWhyThereIsNone) {
  const Ran ran =
      RunProgram({"snapshot", kLaserSingle, "-o", "none.png", "--set", "arrangement=pile", "--set",
                  "clutter.max_draws=1", "--set", "clutter.rest_speed_mm_s=0.01", "--set",
                  "clutter.settle_limit_s=0.5"});
  EXPECT_EQ(ran.code, 1) << ran.out;
  EXPECT_THAT(ran.err, testing::ContainsRegex("-0000 came to rest in view: [a-z_]+ x[0-9]+"));
}

TEST(Usage, ASnapshotWithoutAnOutputIsANewFileInResults) {
  const TempFolder folder;
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  const std::vector<std::string> arguments = {"snapshot", kTabletop, "--size", "16x16"};
  const Ran drawn = RunProgram(arguments);
  const Ran again = RunProgram(arguments);
  std::filesystem::current_path(before);
  EXPECT_EQ(drawn.code, 0) << drawn.err;
  EXPECT_THAT(drawn.err, HasSubstr("picture in results/tabletop.png"));
  EXPECT_TRUE(std::filesystem::exists(folder / "results/tabletop.png"));
  ExpectRefusal(again, "results/tabletop.png: already exists; -o results/tabletop.png replaces it");
}

// In place of python3, a script that reads the files as MuJoCo's viewer would.
TEST(Usage, ViewNeedsADisplayAndHandsTheSettledTrialToTheViewer) {
  const TempFolder folder;
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  ExpectRefused({"view", kTabletop}, "rangegrasp snapshot " + kTabletop + " -o picture.png");
  const auto python = folder.Write("python3",
                                   "#!/bin/sh\nwc -c < $3/model.mjb\nwc -c < $3/state.bin\n"
                                   "[ \"$1\" = -c ] && echo version $4\n");
  std::filesystem::permissions(python, std::filesystem::perms::owner_all);
  const std::string path = std::getenv("PATH");
  setenv("PATH", (folder.path().string() + ":" + path).c_str(), /*overwrite=*/1);
  setenv("DISPLAY", ":99", /*overwrite=*/1);
  const Ran ran = RunProgram({"view", kTabletop});
  folder.Write("python3", "#!/bin/sh\nexit 3\n");
  const Ran failed = RunProgram({"view", kTabletop});
  setenv("PATH", path.c_str(), /*overwrite=*/1);
  unsetenv("DISPLAY");
  EXPECT_EQ(ran.code, 0) << ran.err;
  std::istringstream words(ran.out);
  long model_bytes = 0, state_bytes = 0;
  words >> model_bytes >> state_bytes;
  EXPECT_GT(model_bytes, 100000);
  EXPECT_GT(state_bytes, 0);
  EXPECT_EQ(state_bytes % 8, 0);
  EXPECT_THAT(ran.out, HasSubstr("version 4.0.0"));
  EXPECT_EQ(failed.code, 1);
  EXPECT_THAT(failed.err, HasSubstr("the viewer failed"));
}

TEST(Usage, WhatPicturesNeedIsNamedOrInstalled) {
  const std::string no_mesa = RANGEGRASP_NO_MESA;
  if (no_mesa.empty()) GTEST_SKIP() << "the sanitizer must be loaded first";
  const TempFolder folder;
  const std::vector<std::string> arguments = {"snapshot", kTabletop, "-o", folder / "a.png"};
  Command refused(arguments, "", "/dev/null", no_mesa);
  EXPECT_EQ(refused.Wait(), 2);
  EXPECT_THAT(refused.Err(), HasSubstr("'libosmesa6' is missing"));

  const auto builder = folder.Write("builder", "#!/bin/sh\necho $RANGEGRASP_MISSING_PACKAGE $1\n");
  std::filesystem::permissions(builder, std::filesystem::perms::owner_all);
  setenv("RANGEGRASP_BUILDER", builder.c_str(), /*overwrite=*/1);
  Command installed(arguments, "", "/dev/null", no_mesa);
  unsetenv("RANGEGRASP_BUILDER");
  EXPECT_EQ(installed.Wait(), 0);
  EXPECT_EQ(installed.Out(), "libosmesa6 snapshot\n");
}

// `rangegrasp list keys | true`: the reader exits before the first line is written.
TEST(Output, AReaderThatHasSeenEnoughIsNoError) {
  const TempFolder folder;
  const std::string script = "{ " RANGEGRASP_BINARY " list keys 2>" + (folder / "err").string() +
                             "; echo $? >" + (folder / "code").string() + "; } | true";
  ASSERT_EQ(std::system(script.c_str()), 0);
  while (!std::filesystem::exists(folder / "code")) usleep(1000);
  EXPECT_EQ(base::ReadFile(folder / "code"), "0\n");
  EXPECT_TRUE(std::filesystem::is_empty(folder / "err"));
}

TEST(Version, IsAnOptionToo) {
  const Ran ran = RunProgram({"--version"});
  EXPECT_EQ(ran.code, 0);
  const auto json = nlohmann::json::parse(RunProgram({"version", "--json"}).out);
  EXPECT_EQ(ran.out, "rangegrasp " + json["rangegrasp"].get<std::string>() + "\n");
}

TEST(Version, IsJsonThatNamesTheProgramAndItsLibraries) {
  const auto json = nlohmann::json::parse(Succeeded(RunProgram({"version", "--json"})).out);
  for (const char* name : {"rangegrasp", "commit", "mujoco", "eigen", "cgal", "ompl", "fcl",
                           "embree", "opencv", "sqlite", "yaml-cpp"}) {
    EXPECT_NE(json.value(name, ""), "") << name << "\n" << json;
  }
}

class BadInputTest : public testing::Test {
 protected:
  // An experiment with its own object on the given scene.
  std::string Experiment(const std::string& scene, const std::string& objects = "[thing]") {
    folder_.Write("experiments/e.yaml",
                  "name: demo\nscene: " + scene +
                      "\nsensor: " + (kUsageSource / "models/sensors/line_scanner.yaml").string() +
                      "\nobjects: " + objects + "\n");
    return folder_ / "experiments/e.yaml";
  }
  void Thing(const std::string& mjcf) { folder_.Write("models/objects/thing/thing.xml", mjcf); }
  std::string Out() const { return folder_ / "out"; }

  TempFolder folder_;
};

TEST_F(BadInputTest, ABadExperimentIsNamedWithFileAndLine) {
  ExpectRefused({"run", folder_ / "none.yaml"}, folder_ / "none.yaml");
  const std::string file = folder_.Write("e.yaml", "name: demo\nsceen: x\n");
  ExpectRefused({"run", file, "--out", Out()}, file + ":1: key 'scene'");
  folder_.Write("e.yaml", "name: [\n");
  ExpectRefused({"run", file, "--out", Out()}, file + ":");
  Thing("<mujoco/>");
  const std::string typo = Experiment(kTabletop);
  folder_.Write("experiments/e.yaml",
                base::ReadFile(folder_ / "experiments/e.yaml") + "trails_per_object: 3\n");
  for (const auto& [command, out] :
       {std::pair{"run", "out"}, {"scan", "out.pcd"}, {"snapshot", "out.png"}}) {
    ExpectRefused({command, typo, "-o", folder_ / out},
                  typo + ":5: unknown key 'trails_per_object'");
    EXPECT_FALSE(std::filesystem::exists(folder_ / out));
  }
}

TEST_F(BadInputTest, AMissingOrBrokenSceneIsNamed) {
  Thing(
      "<mujoco><worldbody><body name=\"thing\"><freejoint/><geom size=\".1\"/></body></worldbody>"
      "</mujoco>");
  ExpectRefused({"run", Experiment("missing.xml"), "--out", Out()}, "missing.xml");
  for (const char* text : {"", "no xml", "<mujoco>", "<mujoco><worldbody><geom/></worldbody>"}) {
    const std::string scene = folder_.Write("experiments/broken.xml", text);
    ExpectRefused({"run", Experiment("broken.xml"), "--out", Out()}, scene);
    ExpectRefused({"snapshot", scene, "-o", folder_ / "a.png"}, scene);
    ExpectRefused({"scan", scene, "-o", folder_ / "a.pcd"}, scene);
  }
  ExpectRefused({"snapshot", folder_ / "none.xml", "-o", "a.png"}, "none.xml");
  ExpectRefused({"perceive", "cloud.pcd", "--scene", kLaserSingle},
                kLaserSingle + ": is not XML; an MJCF file (.xml) is needed");
}

TEST_F(BadInputTest, ALinkToItselfIsNamed) {
  const std::string loop = folder_ / "loop";
  std::filesystem::create_symlink("loop", loop);
  for (const char* command : {"table", "trial", "perceive", "run", "check", "snapshot"}) {
    ExpectRefused({command, loop}, "loop: Too many levels of symbolic links");
  }
}

TEST_F(BadInputTest, AMissingSensorIsNamedByItsOption) {
  for (const std::string& file : {kLaserSingle, kTabletop}) {
    ExpectRefused({"scan", file, "--sensor", "none.yaml", "-o", folder_ / "a.pcd"},
                  "error: --sensor: no file 'none.yaml'");
  }
}

TEST_F(BadInputTest, ATaskWithoutPicturesIsNamed) {
  const std::string recall = kUsageSource / "experiments/cylinder_recall.yaml";
  ExpectRefused({"snapshot", recall, "-o", folder_ / "a.png"},
                "has no scene that can be shown (`task: cylinder_recall`); give an experiment that "
                "arranges objects and shows them");
}

TEST_F(BadInputTest, AHandOrAnArmIsNoSceneToDraw) {
  const std::string says = ": it is neither a scene nor an object; to draw ";
  const std::string cure = ", give the scene that attaches it";
  for (const auto& [file, kind] :
       {std::pair{"models/hand/parallel_jaw.xml", "a hand"}, {"models/arm/lwa3.xml", "an arm"}}) {
    const std::string path = kUsageSource / file;
    ExpectRefused({"snapshot", path, "-o", folder_ / "a.png"}, path + ": there is no ");
    ExpectRefused({"snapshot", path, "-o", folder_ / "a.png"}, says + kind + cure);
  }
}

TEST_F(BadInputTest, ASensorsFileIsNoExperimentToCheck) {
  const std::string file = (kUsageSource / "models/sensors/line_scanner.yaml").string();
  ExpectRefused({"check", file}, "line_scanner.yaml: is no experiment");
}

TEST_F(BadInputTest, AnObjectThatIsNoneIsNamed) {
  const std::string model = folder_ / "models/objects/thing/thing.xml";
  for (const char* text : {"", "<mujoco>", "<mujoco/>",
                           // no freejoint
                           "<mujoco><worldbody><body name=\"thing\"><geom "
                           "size=\".1\"/></body></worldbody></mujoco>"}) {
    Thing(text);
    ExpectRefused({"run", Experiment(kTabletop), "--out", Out()}, model);
  }
  ExpectRefused({"run", Experiment(kTabletop, "[thign]"), "--out", Out()}, "nearest: 'thing'");
  const auto none = RunProgram({"run", Experiment(kTabletop, "[none]"), "--out", Out()});
  ExpectRefusal(none, "no object 'none'");
  EXPECT_THAT(none.err, testing::Not(HasSubstr("nearest")));
}

TEST_F(BadInputTest, AnObjectThatIsNoPlaceOfThisWorldIsNamedAtOnce) {
  const std::string model = folder_ / "models/objects/thing/thing.xml";
  for (const char* geom : {"size=\".1\" pos=\"0 0 1e300\"", "size=\"1e300\""}) {
    Thing("<mujoco><worldbody><body name=\"thing\"><freejoint/><geom name=\"g\" " +
          std::string(geom) + " mass=\"1\"/></body></worldbody></mujoco>");
    ExpectRefused({"snapshot", model, "-o", folder_ / "a.png"}, model + ": ");
  }
}

TEST_F(BadInputTest, TextThatIsNotUtf8IsNamed) {
  const std::string file = folder_.Write("e.yaml", "name: demo\n# caf\xe9\n");
  ExpectRefused({"run", file, "--out", Out()}, file + ":2: is not UTF-8");
  ExpectRefused({"perceive", "a\xff.pcd", "--json"}, "argument 2 is not UTF-8");
}

TEST_F(BadInputTest, ACloudThatIsNoneIsNamed) {
  const std::string header =
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n";
  std::string no_points = header;
  no_points.replace(no_points.find("WIDTH 3"), 7, "WIDTH 0");
  no_points.replace(no_points.find("POINTS 3"), 8, "POINTS 0");
  const std::vector<std::pair<std::string, std::string>> files = {
      {"empty.pcd", ""},
      {"text.pcd", "hello\n"},
      {"header.pcd", header},
      {"short.pcd", header + "1 2 3\n"},
      {"words.pcd", header + "a b c\na b c\na b c\n"},
      {"no_points.pcd", no_points},
      {"nan.pcd", header + "nan nan nan\nnan nan nan\nnan nan nan\n"},
      {"few.pcd", header + "0 0 0\n1 0 0\n0 1 0\n"},
      {"far.pcd", header + "0 0 0\n1 0 0\n0 1 1e30\n"},
      {"cloud.xyz", "1 2 3\n"},
      {"text.ply", "ply\nformat ascii 1.0\n"},
  };
  for (const auto& [name, text] : files) {
    const std::string file = folder_.Write(name, text);
    ExpectRefused({"perceive", file}, file);
  }
  ExpectRefused({"perceive", folder_ / "missing.pcd"}, "missing.pcd");
  ExpectRefused({"perceive", folder_.path()}, folder_.path());
}

TEST_F(BadInputTest, AFolderWithoutResultsIsNamed) {
  const std::string folder = folder_.path();
  ExpectRefused({"table", folder}, folder);
  ExpectRefused({"trial", folder, "mug-0000"}, folder);
  ExpectRefused({"compare", folder, folder}, folder);
  ExpectRefused({"merge", folder, "-o", Out()}, folder);
  ExpectRefused({"report", folder, "-o", Out()}, folder);
  folder_.Write("results.sqlite", std::string(4096, 'x'));
  ExpectRefused({"table", folder}, folder);
}

TEST_F(BadInputTest, AnOutputThatCannotBeMadeIsNamed) {
  const std::string below = folder_.Write("file", "") / "below";
  ExpectRefused({"run", kLaserSingle, "--out", below}, below);
  ExpectRefused({"run", kLaserSingle, "--out", "/proc/self"}, "/proc/self");
  ExpectRefused({"snapshot", kTabletop, "-o", below + "/a.png", "--size", "16x16"}, below);
}

// Limits memory as `ulimit -v` does, to values at which libraries would crash.
TEST(LittleMemory, IsSaidAndEndsWithCodeOne) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer needs more address space than any limit leaves";
#endif
  const TempFolder folder;
  for (const rlim_t megabytes : {420, 520, 1000}) {
    const int code = testing_support::InChild([&] {
      const rlimit limit{megabytes << 20U, megabytes << 20U};
      setrlimit(RLIMIT_AS, &limit);
      const Ran ran = RunProgram({"snapshot", kTabletop, "-o", folder / "a.png"});
      return ran.code == 1 && ran.err.find("of memory are needed") != std::string::npos ? 0 : 1;
    });
    EXPECT_EQ(code, 0) << megabytes;
  }
}

TEST(FullDisk, IsSaidAndEndsWithCodeOne) {
  for (const auto& arguments : {std::vector<std::string>{"version"}, {"version", "--json"}}) {
    const Ran ran = RunProgram(arguments, "/dev/full");
    EXPECT_EQ(ran.code, 1);
    EXPECT_THAT(ran.err, HasSubstr("stdout"));
  }
  const TempFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "full.png");
  const Ran ran = RunProgram({"snapshot", kTabletop, "-o", folder / "full.png", "--size", "64x64"});
  EXPECT_EQ(ran.code, 1) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("full.png"));
}

}  // namespace
}  // namespace rangegrasp
