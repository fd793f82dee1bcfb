#include "base/frames.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"

namespace rangegrasp::base {
namespace {

using Eigen::Vector3d;

Vector3d Direction(Rng& rng) {
  return Vector3d(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
}

TEST(Frames, ADirectionIsTurnedOntoAnotherByTheAngleBetweenThem) {
  Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const Vector3d from = Direction(rng);
    const Vector3d to = i == 0 ? Vector3d(-from) : Direction(rng);
    const Eigen::Quaterniond turn = TurnOnto(from, to);
    EXPECT_LT((turn * from - to).norm(), 1e-7);
    EXPECT_NEAR(TurnOf(turn.toRotationMatrix()).angle(),
                std::atan2(from.cross(to).norm(), from.dot(to)), 1e-7);
  }
}

TEST(Frames, ASmallMotionTurnsByTheLengthOfItsVectorAndShifts) {
  Rng rng(2);
  for (int i = 0; i < 100; ++i) {
    const Vector3d turn = rng.Uniform() * Direction(rng);
    const Vector3d shift = Direction(rng);
    const Pose X = SmallMotion(turn, shift);
    const Eigen::AngleAxisd found = TurnOf(X.linear());
    EXPECT_LT((found.angle() * found.axis() - turn).norm(), 1e-12);
    EXPECT_EQ(X.translation(), shift);
  }
  EXPECT_TRUE(SmallMotion(Vector3d::Zero(), Vector3d::Zero()).matrix().isIdentity(0.0));
}

TEST(Frames, TheErrorOfAPoseHasTheSizeThatItIsDrawnWith) {
  Rng rng(3);
  constexpr int kDraws = 4000;
  double shifts_m2 = 0.0, turns_rad2 = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const Pose X = DrawRigidError(0.002, 0.01, rng);
    shifts_m2 += X.translation().squaredNorm();
    turns_rad2 += std::pow(TurnOf(X.linear()).angle(), 2);
  }
  // The mean of 3 n squared normal numbers has a relative standard deviation of sqrt(2 / (3 n)),
  // here 1.3 %; its square root has half of that.
  EXPECT_NEAR(std::sqrt(shifts_m2 / kDraws), 0.002, 4 * 0.0065 * 0.002);
  EXPECT_NEAR(std::sqrt(turns_rad2 / kDraws), 0.01, 4 * 0.0065 * 0.01);
}

}  // namespace
}  // namespace rangegrasp::base
