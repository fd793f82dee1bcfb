#include "sim/internal/servo.h"

#include <gtest/gtest.h>

namespace rangegrasp::sim::internal {
namespace {

base::JointTrajectory Ramp() {
  base::JointTrajectory trajectory;
  trajectory.period_s = 0.01;
  for (int k = 0; k <= 50; ++k)
    trajectory.positions.push_back(Eigen::VectorXd::Constant(2, 0.3 * k * 0.01));
  return trajectory;
}

TEST(CommandAt, IsLinearBetweenSamplesAndFeedsTheSlopeForward) {
  const JointCommand command = CommandAt(Ramp(), 0.1234);
  EXPECT_NEAR(command.position[0], 0.3 * 0.1234, 1e-12);
  EXPECT_NEAR(command.velocity[1], 0.3, 1e-12);
}

TEST(CommandAt, RestsBeforeTheStartAndAfterTheEnd) {
  EXPECT_EQ(CommandAt(Ramp(), -1.0).position[0], 0.0);
  EXPECT_EQ(CommandAt(Ramp(), -1.0).velocity[0], 0.0);
  EXPECT_NEAR(CommandAt(Ramp(), 9.0).position[0], 0.15, 1e-12);
  EXPECT_EQ(CommandAt(Ramp(), 9.0).velocity[0], 0.0);
}

// A 100 Hz staircase would jump by the step of a whole sample.
TEST(CommandAt, ChangesLittleFromStepToStep) {
  const auto trajectory = Ramp();
  for (double t = 0.0; t < 0.5; t += 0.002) {
    EXPECT_LT(
        (CommandAt(trajectory, t + 0.002).position - CommandAt(trajectory, t).position).norm(),
        0.0009);
  }
}

}  // namespace
}  // namespace rangegrasp::sim::internal
