#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/units.h"
#include "error_of.h"
#include "experiment/experiment.h"
#include "recognition/task/bring_task.h"

namespace rangegrasp::bring {
namespace {

using testing::HasSubstr;

Step StepWith(const std::string& grasp, double lean_rad, bool upright) {
  Step step;
  step.at_wanted = true;
  step.grasp = grasp;
  step.asked_upright = upright;
  step.attempt.detected.detection.grasps.emplace_back();
  step.attempt.executed = 0;
  step.attempt.log.emplace();
  step.attempt.log->lean_rad = lean_rad;
  return step;
}

experiment::Record RecordOf(const std::string& group, const std::string& outcome,
                            std::vector<Step> steps) {
  Bring run;
  run.outcome = outcome;
  run.steps = std::move(steps);
  return {{group, group, 1, {}, 0}, ResultOf(run, group, outcome != kSaidAbsent)};
}

std::vector<std::string> RowNamed(const experiment::Grid& grid, const std::string& name) {
  for (const auto& row : grid.rows) {
    if (row.front() == name) return row;
  }
  return {};
}

TEST(BringReport, EveryRunCounts) {
  const auto report =
      ReportOf({}, {RecordOf("cup", "handed_over", {StepWith("handle", base::Deg(29.0), true)}),
                    RecordOf("cup", "handed_over", {StepWith("", base::Deg(31.0), true)}),
                    RecordOf("cup", "wrong_object", {StepWith("", 0.0, false)}),
                    RecordOf("can", kSaidAbsent, {}),
                    RecordOf("can", kNotFound, {}),
                    {{"can", "can", 1, {}, 0}, {"timed_out", "", "", "", {}}}});
  const auto cup = RowNamed(report.csv, "cup");
  ASSERT_EQ(cup.size(), 12u);
  EXPECT_EQ(cup[1], "3");
  EXPECT_EQ(cup[2], "2");
  EXPECT_EQ(cup[8], "1/2") << "one leaned further than 30 deg";
  EXPECT_EQ(cup[11], "wrong_object 1");
  const auto can = RowNamed(report.csv, "can");
  EXPECT_EQ(can[1], "3");
  EXPECT_EQ(can[2], "1");
  EXPECT_EQ(RowNamed(report.csv, "all")[2], "3");
}

TEST(BringTask, ItsSummaryIsTheLastExecutedGraspOfTheWantedObject) {
  Step other = StepWith("lid", 0.0, false);
  other.at_wanted = false;
  Step in_vain = StepWith("", 0.0, false);
  in_vain.attempt.log.reset();
  const auto summary = [](const std::vector<Step>& steps) {
    return BringTask().summary(RecordOf("cup", "handed_over", steps).result);
  };
  EXPECT_THAT(
      summary({StepWith("rim", 0.0, false), StepWith("handle", 0.0, false), other, in_vain}),
      testing::StartsWith("grasp: 'handle' of the object's grasps.yaml, pads closing to "));
  EXPECT_THAT(summary({StepWith("", 0.0, false)}), testing::StartsWith("grasp: power, "));
  EXPECT_EQ(summary({other, in_vain}), "");
  EXPECT_EQ(summary({}), "");
  EXPECT_EQ(BringTask().summary({"crashed", "arrange", "", "{}", {}}), "");
}

TEST(BringRecord, AnAttemptThatEndsWithThePersonIsNotMisplaced) {
  Step taken = StepWith("", 0.0, false);
  taken.attempt.outcome = trial::Outcome::kMisplaced;
  taken.attempt.detail = "too far away";
  taken.attempt.log->held_after_carry = true;
  const auto attempt_of = [](const Step& step) {
    const auto record = RecordOf("cup", "handed_over", {step});
    return nlohmann::json::parse(record.result.data).at("attempts").at(0);
  };
  EXPECT_EQ(attempt_of(taken).at("outcome"), "misplaced") << "put aside";
  EXPECT_EQ(attempt_of(taken).at("detail"), "too far away");
  taken.attempt.log->hand_over = sim::HandOverLog{.felt = true, .taken = true};
  EXPECT_EQ(attempt_of(taken).at("outcome"), "handed_over");
  EXPECT_EQ(attempt_of(taken).at("detail"), "");
}

// Each seed has its own records of all objects.
TEST(BringReport, RunsOfSeveralSeedsAreInOneRow) {
  std::vector<experiment::Record> records;
  for (const char* object : {"cup", "can", "cup", "can"}) {
    records.push_back(RecordOf(object, "handed_over", {StepWith("", 0.0, false)}));
  }
  const auto rows = ReportOf({}, records).csv.rows;
  ASSERT_EQ(rows.size(), 3u);  // with that of all
  EXPECT_EQ(rows[0][0], "cup");
  EXPECT_EQ(rows[1][0], "can");
  for (const std::size_t row : {0u, 1u}) EXPECT_EQ(rows[row][1], "2");
}

TEST(BringReport, WhatThePersonTakesItByIsFreeOrNot) {
  Step touched = StepWith("", 0.0, false);
  touched.touched_kept_free = true;
  const auto report = ReportOf({}, {RecordOf("cup", "handed_over", {touched}),
                                    RecordOf("cup", "handed_over", {StepWith("", 0.0, false)})});
  EXPECT_EQ(RowNamed(report.csv, "cup")[9], "1/2");
}

std::string ErrorOf(const std::vector<std::string>& set) {
  return testing_support::ErrorOf([&] {
    experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/bring.yaml", {.set = set});
  });
}

TEST(BringOptions, KeysOfOtherTasksAreSentToTheirOwn) {
  EXPECT_THAT(ErrorOf({"trials_per_object=3"}), HasSubstr("runs_per_object"));
  EXPECT_THAT(ErrorOf({"views=2"}), HasSubstr("bring.max_looks"));
  EXPECT_THAT(ErrorOf({"bring.use=clean"}),
              testing::AllOf(testing::StartsWith("--set bring.use: key 'use': 'clean' must be one "
                                                 "of drink "),
                             HasSubstr("uses")));
  EXPECT_THAT(ErrorOf({"grasp.take=handle"}), HasSubstr("task: grasping"));
  EXPECT_THAT(ErrorOf({"look.until_probability=0.8"}), HasSubstr("task: grasping"));
}

TEST(BringOptions, ReportingAnAbsentObjectIsSuccess) {
  const auto e = experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/bring.yaml",
                                            {.set = {"bring.absent=true"}});
  EXPECT_EQ(SuccessOf(*e.kind, e.stamp), kSaidAbsent);
}

}  // namespace
}  // namespace rangegrasp::bring
