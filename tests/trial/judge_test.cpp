#include "trial/judge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace rangegrasp::trial {
namespace {

constexpr std::uint32_t kTarget = 1;
constexpr std::uint32_t kOther = 2;

const TargetTruth kTruth{kTarget, {Eigen::Vector3d::UnitZ(), 0.0}, 0.004};

void AddSamples(std::size_t count, std::uint32_t label, double height_m, Sensed& sensed) {
  sensed.observation.views.resize(1);
  sensed.truth.resize(1);
  auto& points = sensed.observation.views[0].image.points_C;
  points.insert(points.end(), count, Eigen::Vector3d(0.0, 0.0, height_m));
  sensed.truth[0].label.insert(sensed.truth[0].label.end(), count, label);
}

// The first samples belong to the first object.
grasp::Detection FirstObjectOf(std::size_t samples) {
  grasp::Detection detection;
  detection.objects.resize(1);
  for (std::uint32_t i = 0; i < samples; ++i) detection.objects[0].samples.push_back({0, i});
  return detection;
}

// A detection whose first object has `target_in` samples of the target and `other_in` others. The
// other `target_out` samples of the target are in another object or were removed by a filter.
DetectionVerdict Judge(std::size_t target_in, std::size_t other_in, std::size_t target_out) {
  Sensed sensed;
  AddSamples(target_in, kTarget, 0.1, sensed);
  AddSamples(other_in, kOther, 0.1, sensed);
  AddSamples(target_out, kTarget, 0.1, sensed);
  return JudgeDetection(FirstObjectOf(target_in + other_in), sensed, kTruth);
}

// A filter removed 536 of 835 samples: the rest is one object, but does not count as a detection.
TEST(JudgeDetection, WhatAFilterAteCountsAgainstIt) { EXPECT_FALSE(Judge(299, 0, 536).segmented); }

// Samples that are so near to the table that the preselection assigns them to it, and unmeasured
// samples, do not count at all.
TEST(JudgeDetection, SamplesAtTheTableDoNotCount) {
  Sensed sensed;
  AddSamples(60, kTarget, 0.1, sensed);
  AddSamples(100, kTarget, 0.0039, sensed);
  AddSamples(100, kTarget, std::numeric_limits<double>::quiet_NaN(), sensed);
  AddSamples(40, kTarget, 0.0041, sensed);
  EXPECT_DOUBLE_EQ(JudgeDetection(FirstObjectOf(60), sensed, kTruth).share_of_target, 0.6);
}

TEST(JudgeDetection, NeedsMoreThanHalfOfTheObjectAndOfTheTarget) {
  struct Case {
    std::size_t target_in, other_in, target_out;
    bool right_target, segmented;
  };
  for (const Case& c :
       {Case{100, 0, 0, true, true}, Case{51, 49, 0, true, true}, Case{50, 50, 0, false, true},
        Case{49, 51, 0, false, true}, Case{51, 0, 49, true, true}, Case{50, 0, 50, true, false},
        Case{49, 0, 51, true, false}, Case{40, 60, 60, false, false},
        Case{0, 100, 100, false, false}, Case{0, 100, 0, false, false},
        Case{0, 0, 100, false, false}, Case{1, 0, 0, true, true}}) {
    const auto verdict = Judge(c.target_in, c.other_in, c.target_out);
    const std::string what = std::to_string(c.target_in) + " " + std::to_string(c.other_in) + " " +
                             std::to_string(c.target_out);
    EXPECT_EQ(verdict.right_target, c.right_target) << what;
    EXPECT_EQ(verdict.segmented, c.segmented) << what;
  }
}

TEST(JudgeDetection, StatesTheShares) {
  const auto verdict = Judge(30, 10, 20);
  EXPECT_DOUBLE_EQ(verdict.share_of_object, 0.75);
  EXPECT_DOUBLE_EQ(verdict.share_of_target, 0.6);
}

TEST(JudgeDetection, NoObjectIsNoDetection) {
  const auto verdict = JudgeDetection({}, {}, kTruth);
  EXPECT_FALSE(verdict.right_target);
  EXPECT_FALSE(verdict.segmented);
}

// The log of a successful trial.
sim::ExecutionLog Delivered() {
  sim::ExecutionLog log;
  log.lift_height_m = 0.2;
  log.held_after_lift = true;
  log.held_after_carry = true;
  log.final_distance_m = 0.01;
  log.at_rest = true;
  log.touched_by_hand = false;
  log.on_support = true;
  return log;
}

struct ExecutionCase {
  const char* what;
  std::function<void(sim::ExecutionLog&)> change;
  Outcome outcome;
};

TEST(JudgeExecution, FollowsTheDefinitions) {
  const double below_lift = std::nextafter(0.1, 0.0);
  const double beyond_place = std::nextafter(0.15, 1.0);
  const std::vector<ExecutionCase> cases = {
      {"all well", [](auto&) {}, Outcome::kDelivered},
      {"lifted by just 100 mm", [](auto& l) { l.lift_height_m = 0.1; }, Outcome::kDelivered},
      {"lifted by less", [&](auto& l) { l.lift_height_m = below_lift; }, Outcome::kNotLifted},
      {"knocked over", [](auto& l) { l.lift_height_m = -0.05; }, Outcome::kNotLifted},
      {"lifted with help", [](auto& l) { l.held_after_lift = false; }, Outcome::kNotLifted},
      {"lost on the way", [](auto& l) { l.held_after_carry = false; }, Outcome::kDropped},
      {"just 150 mm away", [](auto& l) { l.final_distance_m = 0.15; }, Outcome::kDelivered},
      {"further away", [&](auto& l) { l.final_distance_m = beyond_place; }, Outcome::kMisplaced},
      {"still moving", [](auto& l) { l.at_rest = false; }, Outcome::kMisplaced},
      {"still held", [](auto& l) { l.touched_by_hand = true; }, Outcome::kMisplaced},
      {"on the floor", [](auto& l) { l.on_support = false; }, Outcome::kMisplaced},
      {"invalid physics", [](auto& l) { l.audit.failed = "energy"; }, Outcome::kInvalidPhysics},
      {"invalid though dropped",
       [](auto& l) {
         l.audit.failed = "energy";
         l.held_after_carry = false;
       },
       Outcome::kInvalidPhysics},
      {"not lifted comes before dropped",
       [](auto& l) { l.held_after_lift = l.held_after_carry = false; }, Outcome::kNotLifted},
  };
  for (const auto& c : cases) {
    sim::ExecutionLog log = Delivered();
    c.change(log);
    EXPECT_EQ(JudgeExecution(log), c.outcome) << c.what;
  }
}

TEST(JudgeExecution, WhatIsNoNumberIsNoSuccess) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  sim::ExecutionLog log = Delivered();
  log.lift_height_m = nan;
  EXPECT_NE(JudgeExecution(log), Outcome::kDelivered);
  log = Delivered();
  log.final_distance_m = nan;
  EXPECT_NE(JudgeExecution(log), Outcome::kDelivered);
}

TEST(JudgeDetection, LooksUpEverySampleInItsOwnView) {
  Sensed sensed;
  sensed.truth.resize(2);
  sensed.truth[0].label = {kOther, kOther};
  sensed.truth[1].label = {kTarget, kOther};
  sensed.observation.views.resize(2);
  for (auto& view : sensed.observation.views) {
    view.image.points_C.assign(2, Eigen::Vector3d(0.0, 0.0, 0.1));
  }
  grasp::Detection detection;
  detection.objects.resize(1);
  detection.objects[0].samples = {{1, 0}};
  const auto verdict = JudgeDetection(detection, sensed, kTruth);
  EXPECT_DOUBLE_EQ(verdict.share_of_object, 1.0);
  EXPECT_DOUBLE_EQ(verdict.share_of_target, 1.0);
}

}  // namespace
}  // namespace rangegrasp::trial
