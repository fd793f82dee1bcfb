// Tests complete runs of the program on two objects, one trial each, for what a run must not depend
// on.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "experiment/store.h"

namespace rangegrasp {
namespace {

using experiment::Store;
using testing::HasSubstr;
using testing_support::Ran;
using testing_support::RunProgram;
using testing_support::TempFolder;

const std::string kExperiment = RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml";

// Has a reference run that is made once for all tests.
class RunTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder;
    reference_run_ = new Ran(RunInto("single", {"--jobs", "1"}));
  }
  static void TearDownTestSuite() {
    delete reference_run_;
    delete shared_;
  }
  void SetUp() override { ASSERT_EQ(reference_run_->code, 0) << reference_run_->err; }

  static std::string Folder(const std::string& name) { return *shared_ / name; }
  static std::vector<std::string> Arguments(const std::string& name,
                                            const std::vector<std::string>& more,
                                            const std::string& trials = "1") {
    std::vector<std::string> arguments = {"run",   kExperiment,  "--objects", "spread,salt_cuboid",
                                          "--out", Folder(name), "--trials",  trials};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  static Ran RunInto(const std::string& name, const std::vector<std::string>& more) {
    return RunProgram(Arguments(name, more));
  }
  // Every row without its wall times.
  static std::vector<std::string> Rows(const std::string& name) {
    std::vector<std::string> rows;
    for (auto record : Store::Open(Folder(name)).ReadAll()) {
      record.result.seconds.clear();
      rows.push_back(ToJson(record));
    }
    return rows;
  }
  // The results alone, without case and seed.
  static std::vector<std::string> Data(const std::string& name) {
    std::vector<std::string> data;
    for (const auto& record : Store::Open(Folder(name)).ReadAll()) {
      data.push_back(record.result.data);
    }
    return data;
  }
  static nlohmann::json TableOf(const std::string& name) {
    auto json = nlohmann::json::parse(Succeeded(RunProgram({"table", Folder(name), "--json"})).out);
    json.erase("stage_seconds");
    return json;
  }

  static TempFolder* shared_;
  static Ran* reference_run_;
};
TempFolder* RunTest::shared_ = nullptr;
Ran* RunTest::reference_run_ = nullptr;

TEST_F(RunTest, PrintsTheTableBesideThePublishedOne) {
  EXPECT_THAT(reference_run_->out, HasSubstr("published"));
  EXPECT_THAT(reference_run_->out, HasSubstr("pooled: detection"));
  EXPECT_THAT(reference_run_->out, HasSubstr("seed 1,"));
  EXPECT_THAT(reference_run_->err, testing::Not(HasSubstr("\r")));  // no progress bar in a file
}

TEST_F(RunTest, NoTrialCrashesOrTimesOut) {
  for (const auto& record : Store::Open(Folder("single")).ReadAll()) {
    const auto json = nlohmann::json::parse(ToJson(record));
    for (const char* outcome : {"crashed", "timed_out", "invalid_physics"}) {
      EXPECT_NE(json["outcome"], outcome) << json;
    }
    EXPECT_GT(json["data"]["scan_points"], 10000) << json;
  }
}

TEST_F(RunTest, ARowDoesNotDependOnTheOtherObjectsOfItsRun) {
  auto arguments = Arguments("others", {});
  arguments[3] = "salt_cylinder,sweets_cylinder,spread";
  Succeeded(RunProgram(arguments));
  const auto rows = Rows("others");
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[2], Rows("single")[0]);  // spread: the last of the three, the first of the two
}

TEST_F(RunTest, ShardsThatOverlapOrExistAreNotMerged) {
  const Ran ran = Succeeded(RunInto("shard1", {"--shard", "1/2"}));
  EXPECT_THAT(ran.out, HasSubstr("1 of 2 cases are missing"));
  const Ran twice =
      RunProgram({"merge", Folder("shard1"), Folder("shard1"), "-o", Folder("twice")});
  EXPECT_EQ(twice.code, 2);
  EXPECT_THAT(twice.err, HasSubstr("is also in another of the folders"));
  EXPECT_FALSE(std::filesystem::exists(Folder("twice")));
  EXPECT_EQ(RunProgram({"merge", Folder("shard1"), "-o", Folder("single")}).code, 2);
  const Ran one = RunProgram({"merge", Folder("shard1"), "-o", Folder("one")});
  EXPECT_THAT(one.err, HasSubstr("is a shard missing?"));
  EXPECT_EQ(base::ReadFile(Folder("one") + "/experiment.yaml"),
            base::ReadFile(Folder("shard1") + "/experiment.yaml"));
}

TEST_F(RunTest, ExistingResultsAreNotTouchedUnasked) {
  const auto before = Rows("single");
  const Ran ran = RunInto("single", {});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("--resume"));
  const Ran other_seed = RunInto("single", {"--resume", "--seed", "2"});
  EXPECT_EQ(other_seed.code, 2);
  EXPECT_THAT(other_seed.err, HasSubstr("(seed 1 instead of 2)"));
  EXPECT_EQ(Rows("single"), before);
}

TEST_F(RunTest, ResultsAreNotDeletedByARunThatIsToResumeThem) {
  const auto before = Rows("single");
  testing_support::ExpectRefusal(RunInto("single", {"--resume", "--overwrite"}),
                                 "--resume continues existing results, --overwrite deletes them");
  EXPECT_EQ(Rows("single"), before);
}

// The rows of seed 1 are those of the run with only seed 1; the table counts all rows.
TEST_F(RunTest, SeveralSeedsStandInOneTable) {
  Succeeded(RunInto("seeds", {"--seeds", "1,2"}));
  EXPECT_EQ(Rows("seeds/seed-1"), Rows("single"));
  EXPECT_NE(Data("seeds/seed-2"), Data("single"));
  const auto json = TableOf("seeds");
  EXPECT_EQ(json["overall"]["trials"], 4);
  EXPECT_EQ(json["stamp"]["seed"], "1,2");
  const Ran compared = RunProgram({"compare", Folder("seeds"), Folder("single")});
  EXPECT_THAT(compared.out, HasSubstr("pairs 2\n"));
}

// Its results would hide those of the seeds from `table`.
TEST_F(RunTest, AFolderOfSeveralSeedsTakesNoRunOfOne) {
  const std::string of_seed = Folder("of_seeds/seed-1");
  std::filesystem::create_directories(of_seed);
  std::filesystem::copy(Folder("single/results.sqlite"), of_seed);
  const Ran ran = RunInto("of_seeds", {"--seed", "3"});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("holds runs of several seeds"));
  EXPECT_FALSE(Store::Exists(Folder("of_seeds")));
}

TEST_F(RunTest, WrongSeedsAreTold) {
  for (const char* seeds : {"1,x", "1,1", "", "1,,2", "-1"}) {
    const Ran ran = RunInto("wrong_seeds", {std::string("--seeds=") + seeds});
    EXPECT_EQ(ran.code, 2) << seeds;
  }
  EXPECT_EQ(RunInto("wrong_seeds", {"--seeds", "1,2", "--seed", "3"}).code, 2);
  EXPECT_EQ(RunInto("single", {"--seeds", "1,2"}).code, 2);  // has the results of one seed
  EXPECT_FALSE(std::filesystem::exists(Folder("wrong_seeds")));
}

TEST_F(RunTest, ResumingAFinishedRunPrintsItsTable) {
  const Ran ran = Succeeded(RunInto("single", {"--resume"}));
  EXPECT_EQ(ran.out, reference_run_->out);
}

// More trials continue with the existing ones, and the result equals a run with all trials at once.
TEST_F(RunTest, MoreTrialsAreAddedToARun) {
  ASSERT_EQ(RunInto("more", {}).code, 0);
  const auto with_two = [](const std::string& name, const std::string& flag) {
    return RunProgram(Arguments(name, {flag}, "2"));
  };
  const Ran more = Succeeded(with_two("more", "--resume"));
  EXPECT_THAT(more.err, HasSubstr("2 cases in"));
  const Ran at_once = Succeeded(with_two("at_once", "--overwrite"));
  EXPECT_EQ(Rows("more"), Rows("at_once"));
  EXPECT_EQ(Store::Open(Folder("more")).ReadStamp(), Store::Open(Folder("at_once")).ReadStamp());
  const Ran shard = RunProgram(Arguments("more", {"--resume", "--shard", "1/2"}, "3"));
  EXPECT_EQ(shard.code, 2);
  EXPECT_THAT(shard.err, HasSubstr("is a shard of 4 cases"));
}

TEST_F(RunTest, AFolderWithoutACaseHoldsNoResults) {
  Store::Create(Folder("empty"));
  EXPECT_EQ(RunInto("empty", {}).code, 0);
  EXPECT_EQ(Rows("empty"), Rows("single"));
}

TEST_F(RunTest, TheFolderHoldsTheExperimentFile) {
  const std::string text = base::ReadFile(Folder("single/experiment.yaml"));
  EXPECT_THAT(text, testing::EndsWith(base::ReadFile(kExperiment)));
  EXPECT_THAT(text, HasSubstr("--set 'trials_per_object=1'\n"));
}

TEST_F(RunTest, TheCopyOfTheExperimentFileSaysWhereItsPathsBegin) {
  testing_support::ExpectRefused({"check", Folder("single/experiment.yaml")},
                                 "whose relative paths are relative to " RANGEGRASP_SOURCE_DIR
                                 "/experiments: give");
}

TEST_F(RunTest, ASnapshotOfResultsNamesTheCommandThatDrawsTheirTrials) {
  testing_support::ExpectRefused(
      {"snapshot", Folder("single"), "-o", Folder("single.png"), "--trial", "spread-0000"},
      "is a results folder; `rangegrasp trial " + Folder("single") + " ID --snapshots`");
}

TEST_F(RunTest, ATaskWithoutTableFilesSaysSo) {
  const Ran ran = Succeeded(RunProgram({"table", Folder("single"), "--files"}));
  EXPECT_THAT(ran.err, HasSubstr("task grasping has no table files or figures"));
}

TEST_F(RunTest, TrialsOfAPythonFunctionAreNotRunAgainButTheirRecordsAreRead) {
  const Store single = Store::Open(Folder("single"));
  Store of_function = Store::Create(Folder("of_function"));
  auto stamp = single.ReadStamp();
  stamp.identity["detector_function"] = "det 0123";
  stamp.data["set"] += "\ndetector=python";
  of_function.WriteStamp(stamp);
  for (const auto& record : single.ReadAll()) of_function.Write(record);
  of_function.Finish();
  testing_support::ExpectRefused(
      {"trial", Folder("of_function"), "spread-0000"},
      "error: " + Folder("of_function") + ": the detector was the Python function det 0123: only");
  Succeeded(RunProgram({"report", Folder("of_function"), "--views", "none"}));
  Succeeded(RunProgram({"export", Folder("of_function"), "-o", Folder("of_function_set")}));
}

TEST_F(RunTest, EveryFormatOfTheTableIsWhatItsNameSays) {
  const auto json = TableOf("single");
  ASSERT_EQ(json["rows"].size(), 2u);
  EXPECT_EQ(json["experiment"], "laser_single");
  // The order is as in the experiment file.
  EXPECT_EQ(json["rows"][0]["object"], "spread");
  EXPECT_EQ(json["rows"][1]["object"], "salt_cuboid");
  EXPECT_EQ(json["rows"][0]["published_detection_rate"], 0.9);
  EXPECT_EQ(json["overall"]["trials"], 2);
  EXPECT_FALSE(json["stamp"].contains("reference"));
  EXPECT_EQ(json["stamp"]["seed"], "1");

  const Ran csv = RunProgram({"table", Folder("single"), "--format", "csv"});
  EXPECT_EQ(std::count(csv.out.begin(), csv.out.end(), '\n'), 4);
  EXPECT_THAT(csv.out, testing::StartsWith("object,title,trials,"));
  const Ran markdown = RunProgram({"table", Folder("single"), "--format", "markdown"});
  EXPECT_THAT(markdown.out, testing::StartsWith("| no. | object |"));
}

TEST_F(RunTest, ATableThatCannotBeWrittenWholeIsAnError) {
  EXPECT_EQ(RunProgram({"table", Folder("single")}, "/dev/full").code, 1);
}

TEST_F(RunTest, ACameraOfPicturesMustExist) {
  testing_support::ExpectRefused(
      {"trial", Folder("single"), "spread-0000", "--snapshots", "--camera", "nowhere"}, "overview");
  testing_support::ExpectRefused({"trial", Folder("single"), "spread-0000", "--camera", "overview"},
                                 "--camera needs --snapshots or --video");
}

TEST_F(RunTest, OnlyTasksWithASuccessAreCompared) {
  Succeeded(RunProgram({"run", RANGEGRASP_SOURCE_DIR "/experiments/seam_base.yaml", "--trials", "1",
                        "--out", Folder("seam")}));
  testing_support::ExpectRefused({"compare", Folder("seam"), Folder("seam")},
                                 "has no outcome that counts as success");
}

TEST_F(RunTest, AReplayedTrialGivesTheSameRow) {
  const Ran ran = Succeeded(RunProgram({"trial", Folder("single"), "spread-0000", "--json"}));
  EXPECT_EQ(ran.err, "");  // no warning about a difference
  auto replayed = nlohmann::ordered_json::parse(ran.out);
  replayed["seconds"] = nlohmann::ordered_json::object();
  EXPECT_EQ(replayed.dump(), Rows("single").front());
  const std::string text = RunProgram({"trial", Folder("single"), "spread-0000"}).out;
  EXPECT_THAT(text, testing::StartsWith("spread-0000: " + replayed["outcome"].get<std::string>()));
  EXPECT_THAT(text, HasSubstr("scene_objects 1"));
  EXPECT_THAT(text, HasSubstr("seconds: arrange 0."));
  const Ran bad = RunProgram({"trial", Folder("single"), "spread-0001"});
  EXPECT_EQ(bad.code, 2);
  EXPECT_THAT(bad.err, HasSubstr("spread-0001"));
}

// Scenes of this task have neither pictures nor figures of their own.
TEST_F(RunTest, AReplayWithoutPicturesSaysThat) {
  Succeeded(RunProgram({"run", RANGEGRASP_SOURCE_DIR "/experiments/cylinder_recall.yaml", "--set",
                        "source=perfect", "--trials", "1", "--out", Folder("recall")}));
  const Ran ran = Succeeded(RunProgram({"trial", Folder("recall"), "scene-0000", "--snapshots"}));
  EXPECT_THAT(ran.err, HasSubstr("task cylinder_recall has no pictures"));
  EXPECT_THAT(ran.err, testing::Not(HasSubstr("pictures in")));
  EXPECT_THAT(ran.out, testing::StartsWith("scene-0000: scored in stage detect\n  seconds: "));
  EXPECT_FALSE(std::filesystem::exists(Folder("recall/snapshots")));
  testing_support::ExpectRefused(
      {"trial", Folder("recall"), "scene-0000", "--video", Folder("recall.mp4")},
      "--video, --camera: this task has no pictures");
}

// In a folder that cannot hold the pictures, the trial would seem to crash.
TEST_F(RunTest, PicturesThatCannotBeWrittenAreNoChangeOfTheProgram) {
  std::filesystem::create_directories(Folder("unwritable"));
  std::filesystem::copy(Folder("single/results.sqlite"), Folder("unwritable"));
  base::WriteFile(Folder("unwritable/snapshots"), "no folder");
  const Ran ran = RunProgram({"trial", Folder("unwritable"), "spread-0000", "--snapshots"});
  testing_support::ExpectRefusal(ran, Folder("unwritable/snapshots") + ": the folder cannot be");
  EXPECT_THAT(ran.err, testing::Not(HasSubstr("has the program")));
}

// The reference run's first record 25 times, the last time with another outcome.
TEST_F(RunTest, ATrialWithoutAnIdListsTheCasesFailedOnesFirst) {
  const Store single = Store::Open(Folder("single"));
  Store many = Store::Create(Folder("many"));
  many.WriteStamp(single.ReadStamp());
  auto record = single.ReadAll().front();
  record.result.outcome = "delivered";
  for (int i = 0; i < 25; ++i) {
    record.which.id = "spread-" + std::to_string(1000 + i);
    record.which.position = i;
    if (i == 24) record.result.outcome = "dropped";
    many.Write(record);
  }
  many.Finish();
  const Ran listed = Succeeded(RunProgram({"trial", Folder("many")}));
  const auto place = [&](const std::string& id) { return listed.out.find(id); };
  EXPECT_LT(place("spread-1024"), place("spread-1000"));
  EXPECT_LT(place("spread-1000"), place("spread-1018"));
  EXPECT_THAT(listed.out, testing::ContainsRegex("spread-1024 +spread +dropped"));
  EXPECT_THAT(listed.out, testing::Not(HasSubstr("spread-1019")));
  EXPECT_THAT(listed.out, HasSubstr("and 5 more (--json lists all)\n"));
  const Ran json = Succeeded(RunProgram({"trial", Folder("many"), "--json"}));
  EXPECT_EQ(std::ranges::count(json.out, '\n'), 25);
  testing_support::ExpectRefused({"trial", Folder("many"), "--snapshots"}, "need an id");
}

TEST_F(RunTest, AReplayedTrialNamesItsGrasp) {
  const auto record = Store::Open(Folder("single")).ReadAll().front();
  const auto data = nlohmann::json::parse(record.result.data);
  const Ran ran = Succeeded(RunProgram({"trial", Folder("single"), record.which.id}));
  EXPECT_THAT(ran.out, HasSubstr("\n  grasp: " + data["grasp_type"].get<std::string>() + ", pads"));
}

TEST_F(RunTest, AComparisonNamesTheKeysInWhichTheRunsDiffer) {
  const Store single = Store::Open(Folder("single"));
  auto stamp = single.ReadStamp();
  for (int i = 0; i < 11; ++i) stamp.data["set"] += "\nhand.key_" + std::to_string(10 + i) + "=0.5";
  Store other = Store::Create(Folder("other_keys"));
  other.WriteStamp(stamp);
  for (const auto& record : single.ReadAll()) other.Write(record);
  other.Finish();
  const Ran ran = Succeeded(RunProgram({"compare", Folder("single"), Folder("other_keys")}));
  EXPECT_THAT(ran.out, HasSubstr("\n  hand.key_10: not given in the first, 0.5 in the second\n"));
  EXPECT_THAT(ran.out, testing::Not(HasSubstr("hand.key_20")));
  EXPECT_THAT(ran.out, HasSubstr("\n  and 1 more\npairs 2\n"));
  const Ran same = Succeeded(RunProgram({"compare", Folder("single"), Folder("single")}));
  EXPECT_THAT(same.out, HasSubstr("the experiments have the same keys\n"));
}

TEST_F(RunTest, ARunComparedWithItselfHasNoDiscordantPair) {
  const Ran ran = Succeeded(RunProgram({"compare", Folder("single"), Folder("single")}));
  EXPECT_THAT(ran.out, HasSubstr("pairs 2"));
  EXPECT_THAT(ran.out, HasSubstr("same outcome 2"));
  EXPECT_THAT(ran.out, HasSubstr("McNemar exact p 1"));
  EXPECT_EQ(ran.err, "");
}

TEST_F(RunTest, AComparisonOfDifferentExperimentsWarns) {
  Succeeded(RunInto("renamed", {"--set", "name=renamed"}));
  const Ran ran = Succeeded(RunProgram({"compare", Folder("single"), Folder("renamed")}));
  EXPECT_THAT(ran.err, HasSubstr("renamed (renamed) are runs of different experiments"));
  EXPECT_THAT(base::ReadFile(Folder("renamed/experiment.yaml")),
              HasSubstr("# What ran (--objects): "));
}

TEST_F(RunTest, AScanIsPerceivedAsAFileToo) {
  const std::string cloud = Folder("spread.pcd");
  const auto scanned = [&] {
    Succeeded(RunProgram({"scan", kExperiment, "--trial", "spread-0000", "-o", cloud}));
    return base::ReadFile(cloud);
  };
  EXPECT_EQ(scanned(), scanned());
  const Ran ran = Succeeded(RunProgram(
      {"perceive", cloud, "--sensor-origin", "0.8,0,0.62", "--json", "-o", Folder("seen")}));
  const auto json = nlohmann::json::parse(ran.out);
  ASSERT_GE(json["objects"].size(), 1u);
  EXPECT_GT(json["table"]["normal"][2].get<double>(), 0.999);
  EXPECT_TRUE(json["objects"][0].contains("grasps"));
  EXPECT_TRUE(std::filesystem::exists(Folder("seen/perceived.png")));
  EXPECT_EQ(nlohmann::json::parse(base::ReadFile(Folder("seen/perceived.json"))), json);
}

}  // namespace
}  // namespace rangegrasp
