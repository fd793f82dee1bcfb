// Whole runs of the program on two objects, one trial each: what a run may not depend on.

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
using testing_support::Command;
using testing_support::Ran;
using testing_support::RunProgram;
using testing_support::TempFolder;

const std::string kExperiment = RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml";

// One reference run, made once for all tests.
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

  static std::string Folder(const std::string& name) { return (*shared_ / name).string(); }
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
  // Every row but its wall times.
  static std::vector<std::string> Rows(const std::string& name) {
    std::vector<std::string> rows;
    for (auto result : Store::Open(Folder(name)).ReadAll()) {
      result.seconds.clear();
      rows.push_back(ToJson(result));
    }
    return rows;
  }
  static nlohmann::json TableOf(const std::string& name) {
    const Ran ran = RunProgram({"table", Folder(name), "--json"});
    EXPECT_EQ(ran.code, 0) << ran.err;
    auto json = nlohmann::json::parse(ran.out);
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
  EXPECT_THAT(reference_run_->out, HasSubstr("seed 1, 2 trials"));
  EXPECT_THAT(reference_run_->err, testing::Not(HasSubstr("\r")));  // no progress bar in a file
}

TEST_F(RunTest, NoTrialCrashesOrTimesOut) {
  for (const auto& result : Store::Open(Folder("single")).ReadAll()) {
    EXPECT_NE(result.outcome, experiment::Outcome::kCrashed) << ToJson(result);
    EXPECT_NE(result.outcome, experiment::Outcome::kTimedOut) << ToJson(result);
    EXPECT_NE(result.outcome, experiment::Outcome::kInvalidPhysics) << ToJson(result);
    EXPECT_GT(result.scan_points, 10000) << ToJson(result);
  }
}

TEST_F(RunTest, TwoJobsGiveTheSameRows) {
  const Ran ran = RunInto("jobs2", {"--jobs", "2"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_EQ(Rows("jobs2"), Rows("single"));
}

TEST_F(RunTest, ARowDoesNotDependOnTheOtherObjectsOfItsRun) {
  auto arguments = Arguments("others", {});
  arguments[3] = "salt_cylinder,sweets_cylinder,spread";
  const Ran ran = RunProgram(arguments);
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_EQ(Rows("others")[1], Rows("single")[1]);  // by id: spread is the second of either
}

TEST_F(RunTest, AKilledAndResumedRunGivesTheSameRows) {
  ASSERT_EQ(RunProgram(Arguments("whole", {"--jobs", "1"}, "6")).code, 0);
  Command command(Arguments("killed", {"--jobs", "2"}, "6"));
  const auto rows_so_far = [] {
    try {
      return Store::Open(Folder("killed")).ReadAll().size();
    } catch (const std::exception&) {
      return std::size_t{0};  // not there yet
    }
  };
  while (command.Runs() && rows_so_far() < 1) usleep(2000);
  command.Kill();
  const auto whole = Rows("whole");
  for (const auto& row : Rows("killed")) EXPECT_THAT(whole, testing::Contains(row));
  ASSERT_GE(Rows("killed").size(), 1u);
  ASSERT_LT(Rows("killed").size(), whole.size());
  const Ran resumed = RunProgram(Arguments("killed", {"--jobs", "2", "--resume"}, "6"));
  ASSERT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_EQ(Rows("killed"), whole);
  EXPECT_EQ(TableOf("killed"), TableOf("whole"));
}

TEST_F(RunTest, ShardsMergeToTheTableOfASingleRun) {
  for (const char* shard : {"1", "2"}) {
    const Ran ran = RunInto(std::string("shard") + shard, {"--shard", std::string(shard) + "/2"});
    ASSERT_EQ(ran.code, 0) << ran.err;
    EXPECT_EQ(Rows(std::string("shard") + shard).size(), 1u);
  }
  const Ran merged =
      RunProgram({"merge", Folder("shard1"), Folder("shard2"), "-o", Folder("merged")});
  ASSERT_EQ(merged.code, 0) << merged.err;
  EXPECT_EQ(Rows("merged"), Rows("single"));
  EXPECT_EQ(TableOf("merged"), TableOf("single"));

  const Ran again =
      RunProgram({"merge", Folder("shard1"), Folder("shard1"), "-o", Folder("twice")});
  EXPECT_EQ(again.code, 2);
  EXPECT_THAT(again.err, HasSubstr("is in another of the folders too"));
  EXPECT_FALSE(std::filesystem::exists(Folder("twice")));
  EXPECT_EQ(RunProgram({"merge", Folder("shard1"), "-o", Folder("merged")}).code, 2);
}

TEST_F(RunTest, ExistingResultsAreNotTouchedUnasked) {
  const auto before = Rows("single");
  const Ran ran = RunInto("single", {});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("--resume"));
  const Ran other_seed = RunInto("single", {"--resume", "--seed", "2"});
  EXPECT_EQ(other_seed.code, 2);
  EXPECT_THAT(other_seed.err, HasSubstr("another seed"));
  EXPECT_EQ(Rows("single"), before);
}

TEST_F(RunTest, ResumingAFinishedRunPrintsItsTable) {
  const Ran ran = RunInto("single", {"--resume"});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_EQ(ran.out, reference_run_->out);
}

TEST_F(RunTest, EveryFormatOfTheTableIsWhatItsNameSays) {
  const auto json = TableOf("single");
  ASSERT_EQ(json["rows"].size(), 2u);
  EXPECT_EQ(json["experiment"], "laser_single");
  // The order is that of the experiment file.
  EXPECT_EQ(json["rows"][0]["object"], "spread");
  EXPECT_EQ(json["rows"][1]["object"], "salt_cuboid");
  EXPECT_EQ(json["rows"][0]["published_detection_rate"], 0.9);
  EXPECT_EQ(json["overall"]["trials"], 2);
  EXPECT_FALSE(json["stamp"].contains("reference"));

  const Ran csv = RunProgram({"table", Folder("single"), "--format", "csv"});
  EXPECT_EQ(std::count(csv.out.begin(), csv.out.end(), '\n'), 4);
  EXPECT_THAT(csv.out, testing::StartsWith("object,title,trials,"));
  const Ran markdown = RunProgram({"table", Folder("single"), "--format", "markdown"});
  EXPECT_THAT(markdown.out, testing::StartsWith("| no. | object |"));
  const Ran file = RunProgram({"table", Folder("single"), "--json", "--out", Folder("table.json")});
  EXPECT_EQ(file.out, "");
  EXPECT_TRUE(nlohmann::json::parse(core::ReadFile(Folder("table.json"))).contains("rows"));
}

TEST_F(RunTest, ATableThatCannotBeWrittenWholeIsAnError) {
  EXPECT_EQ(RunProgram({"table", Folder("single")}, "/dev/full").code, 1);
  const Ran ran = RunProgram({"table", Folder("single"), "--out", "/dev/full"});
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.err, HasSubstr("/dev/full"));
}

TEST_F(RunTest, AReplayedTrialGivesTheSameRow) {
  const Ran ran = RunProgram({"trial", Folder("single"), "spread-0000"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_EQ(ran.err, "");  // no warning that it differs
  auto replayed = experiment::FromJson(ran.out);
  replayed.seconds.clear();
  EXPECT_EQ(ToJson(replayed), Rows("single").back());  // by id: salt_cuboid, spread
  const Ran bad = RunProgram({"trial", Folder("single"), "spread-0001"});
  EXPECT_EQ(bad.code, 2);
  EXPECT_THAT(bad.err, HasSubstr("spread-0001"));
}

TEST_F(RunTest, ARunComparedWithItselfHasNoDiscordantPair) {
  const Ran ran = RunProgram({"compare", Folder("single"), Folder("single")});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("pairs 2"));
  EXPECT_THAT(ran.out, HasSubstr("same outcome 2"));
  EXPECT_THAT(ran.out, HasSubstr("McNemar exact p 1"));
}

TEST_F(RunTest, AScanIsPerceivedAsAFileToo) {
  const std::string cloud = Folder("spread.pcd");
  const Ran scan = RunProgram({"scan", kExperiment, "--trial", "spread-0000", "-o", cloud});
  ASSERT_EQ(scan.code, 0) << scan.err;
  const std::string bytes = core::ReadFile(cloud);
  const Ran again = RunProgram({"scan", kExperiment, "--trial", "spread-0000", "-o", cloud});
  EXPECT_EQ(core::ReadFile(cloud), bytes);
  const Ran ran = RunProgram(
      {"perceive", cloud, "--sensor-origin", "0.8,0,0.62", "--json", "-o", Folder("seen")});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto json = nlohmann::json::parse(ran.out);
  ASSERT_GE(json["objects"].size(), 1u);
  EXPECT_GT(json["table"]["normal"][2].get<double>(), 0.999);
  EXPECT_TRUE(json["objects"][0].contains("grasps"));
  EXPECT_TRUE(std::filesystem::exists(Folder("seen/perceived.png")));
  EXPECT_EQ(nlohmann::json::parse(core::ReadFile(Folder("seen/perceived.json"))), json);
}

}  // namespace
}  // namespace rangegrasp
