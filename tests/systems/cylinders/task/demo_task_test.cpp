#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cylinders/task/demo_detector.h"
#include "experiment/experiment.h"
#include "temp_folder.h"

namespace rangegrasp::cylinders {
namespace {

experiment::Experiment DemoTaskOpen(const std::vector<std::string>& set = {}) {
  return experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/cylinder_demo.yaml",
                                    {.set = set, .seed = 11});
}

nlohmann::json DataOf(const experiment::Result& result) {
  return nlohmann::json::parse(result.data);
}

// Run 0 of seed 11, in which nothing stands in the way.
TEST(DemoTask, FindsGraspsCarriesAndHandsOver) {
  const auto experiment = DemoTaskOpen();
  const auto result = experiment.task->Run(experiment.cases[0]);
  EXPECT_EQ(result.outcome, "handed_over") << result.detail;
  EXPECT_EQ(result.detail, "");
  const auto data = DataOf(result);
  // Two given cylinders and 3 to 6 other objects.
  EXPECT_GE(data["scene_objects"], 5);
  EXPECT_LE(data["scene_objects"], 8);
  ASSERT_EQ(data["tries"].size(), 1u);
  // Three times the calibration's error of 1 mm and 0.1 deg at 1 m.
  EXPECT_LT(data["tries"][0]["found"]["across_error_m"], 0.006);
  const auto log = data["log"];
  EXPECT_TRUE(log["held_after_carry"]);
  EXPECT_TRUE(log["hand_over"]["felt"]);
  EXPECT_FALSE(log["touched_by_hand"]);
}

TEST(DemoTask, PutsItDownWhereNobodyTakesIt) {
  const auto experiment = DemoTaskOpen({"demo.delivery=place"});
  const auto result = experiment.task->Run(experiment.cases[0]);
  EXPECT_EQ(result.outcome, "delivered") << result.detail;
  EXPECT_FALSE(DataOf(result)["log"].contains("hand_over"));
}

TEST(DemoTask, APersonWhoHardlyPullsGetsNothing) {
  const auto experiment = DemoTaskOpen({"demo.user.force_n=0.5"});
  const auto result = experiment.task->Run(experiment.cases[0]);
  EXPECT_EQ(result.outcome, "not_felt");
  EXPECT_FALSE(DataOf(result)["log"]["hand_over"]["taken"]);
}

TEST(DemoTask, ACylinderOfAnotherShapeIsNotFound) {
  const auto experiment = DemoTaskOpen({"cylinders=[29x195, 26.75x134]", "demo.max_tries=2"});
  const auto result = experiment.task->Run(experiment.cases[0]);
  EXPECT_EQ(result.outcome, "not_segmented");
  // It looks again until no tries are left, and reports the result of each.
  const auto tries = DataOf(result)["tries"];
  ASSERT_EQ(tries.size(), 2u);
  EXPECT_TRUE(tries[1]["found"].is_null());
}

TEST(DemoTask, OnlyWhatTheRobotNoticesIsTriedAgain) {
  trial::Attempt attempt;
  attempt.outcome = trial::Outcome::kNoPath;
  EXPECT_TRUE(KnowsItFailed(attempt, Delivery::kHandOver));
  attempt.log.emplace();  // the hand closed on nothing and detects this
  attempt.outcome = trial::Outcome::kNotLifted;
  EXPECT_TRUE(KnowsItFailed(attempt, Delivery::kHandOver));
  EXPECT_TRUE(KnowsItFailed(attempt, Delivery::kPlace));
  attempt.log->aperture.feels_object_after_carry = true;
  EXPECT_FALSE(KnowsItFailed(attempt, Delivery::kPlace));
  attempt.log->hand_over.emplace();  // nobody pulled: nothing more can be done
  EXPECT_FALSE(KnowsItFailed(attempt, Delivery::kHandOver));
  trial::Attempt broken;
  EXPECT_FALSE(KnowsItFailed(broken, Delivery::kHandOver));
}

TEST(DemoTask, ReplayShowsWhatWasDetectedAndEndsAsTheRun) {
  const testing_support::TempFolder folder;
  const auto experiment = DemoTaskOpen();
  experiment::ReplayOptions options;
  options.folder = folder.path();
  options.snapshots = true;
  const auto replayed = experiment.task->Replay(experiment.cases[0], options);
  EXPECT_EQ(replayed.data, experiment.task->Run(experiment.cases[0]).data);
  for (const char* what : {"scan.pcd", "cylinders.png", "waits.png", "taken.png"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / ("run-0000_" + std::string(what)))) << what;
  }
}

}  // namespace
}  // namespace rangegrasp::cylinders
