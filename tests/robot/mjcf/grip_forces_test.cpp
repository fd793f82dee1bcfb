#include "robot/mjcf/grip_forces.h"

#include <gtest/gtest.h>

#include <cmath>

#include "robot/mjcf/example_hands.h"

namespace rangegrasp::mjcf {
namespace {

using samples::LoadHand;

std::vector<double> ForcesAt(const mjModel* model, double share) {
  const HandClosing closing = CloseOnNothing(model);
  const samples::DataPtr data(mj_makeData(model), mj_deleteData);
  closing.Pose(model, data.get(), share);
  mj_forward(model, data.get());
  return GripForces(model, data.get(), HandMotors(model), closing, share, Eigen::Vector3d::UnitX());
}

// One drive pulls both jaws: 2 N for 1 N at either, and towards lower positions.
TEST(GripForces, OneDriveOfTwoJawsGivesTwice) {
  const auto model = LoadHand("parallel_jaw");
  const auto forces = ForcesAt(model.get(), 0.5);
  ASSERT_EQ(forces.size(), 1u);
  EXPECT_NEAR(forces[0], -2.0, 0.02);
}

// A last segment that stays upright presses with torque / (55 mm cos(30 deg - q)), wherever it is
// pressed: its follower's equality carries the rest. Two fingers share what the thumb gives.
TEST(GripForces, FollowersLeaveTheDriveItsFirstSegmentsLever) {
  const auto model = LoadHand("three_fingers");
  for (const double share : {0.1, 0.5, 0.8}) {
    const auto forces = ForcesAt(model.get(), share);
    const double lever_m = 0.055 * std::cos(mjPI / 6 - 1.16 * share);
    ASSERT_EQ(forces.size(), 3u);
    EXPECT_NEAR(forces[0], lever_m, 5e-4) << share;
    EXPECT_NEAR(forces[1], 0.5 * lever_m, 5e-4) << share;
    EXPECT_NEAR(forces[2], 0.5 * lever_m, 5e-4) << share;
  }
}

}  // namespace
}  // namespace rangegrasp::mjcf
