#include "robot/timing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/rng.h"
#include "base/units.h"
#include "robot/ik.h"
#include "robot/test_cells.h"

namespace rangegrasp::robot {
namespace {

using Path = std::vector<Eigen::VectorXd>;

double DistanceToPath(const Eigen::VectorXd& q, const Path& path) {
  double best = (q - path.front()).norm();
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Eigen::VectorXd leg = path[i] - path[i - 1];
    const double t = leg.squaredNorm() > 0.0
                         ? std::clamp((q - path[i - 1]).dot(leg) / leg.squaredNorm(), 0.0, 1.0)
                         : 0.0;
    best = std::min(best, (q - path[i - 1] - t * leg).norm());
  }
  return best;
}

/// The mean of a motion with acceleration a over smoothing_s is within a smoothing_s^2 / 24 of the
/// motion's midpoint.
double SmoothingDeviation(const Robot& robot, const TimingOptions& options) {
  return options.acceleration_scale * robot.acceleration.norm() * options.smoothing_s *
         options.smoothing_s / 24.0;
}

void ExpectWithinLimits(const Robot& robot, const base::JointTrajectory& trajectory,
                        const TimingOptions& options) {
  const double dt = trajectory.period_s;
  // A mean of values within the limits is within them, except for rounding: 1e-15 / dt^2.
  const Eigen::ArrayXd v = options.velocity_scale * robot.velocity.array() + 1e-9;
  const Eigen::ArrayXd a = options.acceleration_scale * robot.acceleration.array() + 1e-9;
  const Path& q = trajectory.positions;
  for (std::size_t i = 0; i < q.size(); ++i) {
    // The robot is at rest before and after.
    const Eigen::VectorXd& before = q[i == 0 ? 0 : i - 1];
    const Eigen::VectorXd& after = q[std::min(i + 1, q.size() - 1)];
    ASSERT_LE(((after - q[i]).array().abs() / dt / v).maxCoeff(), 1.0) << "sample " << i;
    ASSERT_LE(((after - 2.0 * q[i] + before).array().abs() / (dt * dt) / a).maxCoeff(), 1.0)
        << "sample " << i;
  }
}

class Timing : public ::testing::TestWithParam<int> {
 protected:
  Robot robot_ = Robot::Load(SmallCell());
};

TEST_P(Timing, RandomPathsKeepAllLimitsMeetTheirEndsAndStayNear) {
  base::Rng rng(static_cast<std::uint64_t>(GetParam()));
  for (int n = 0; n < 10; ++n) {
    Path path{RandomJoints(robot_, rng)};
    const std::size_t count = 2 + rng.Index(7);
    const double reach = n % 2 == 0 ? 1.0 : 0.05;  // long and short segments
    while (path.size() < count) {
      path.push_back(path.back() + reach * (RandomJoints(robot_, rng) - path.back()));
    }
    TimingOptions options;
    options.velocity_scale = rng.Uniform(0.3, 1.0);
    options.acceleration_scale = rng.Uniform(0.3, 1.0);
    const auto trajectory = TimeParameterise(robot_, path, options);
    EXPECT_EQ(trajectory.positions.front(), path.front());
    EXPECT_EQ(trajectory.positions.back(), path.back());
    ExpectWithinLimits(robot_, trajectory, options);
    const double bound = options.corner_rad + SmoothingDeviation(robot_, options) + 1e-9;
    for (const auto& q : trajectory.positions) EXPECT_LE(DistanceToPath(q, path), bound);
  }
}

TEST_P(Timing, DenseHandLinesAreFollowedClosely) {
  base::Rng rng(static_cast<std::uint64_t>(GetParam()) + 100);
  Eigen::VectorXd q0(7);
  q0 << 0.0, 0.2, 0.0, 1.4, 0.0, 1.4, 0.0;  // the hand in front of the arm, pointing down
  q0 += 0.1 * RandomJoints(robot_, rng);
  base::Pose X_WH = robot_.HandPose(q0);
  X_WH.translation() += Eigen::Vector3d(0.12, 0.05, -0.12);
  const auto line = StraightLine(robot_, q0, X_WH);
  ASSERT_TRUE(line);
  const auto trajectory = TimeParameterise(robot_, *line, {});
  ExpectWithinLimits(robot_, trajectory, {});
  const Eigen::Vector3d from_W = robot_.HandPose(q0).translation();
  const Eigen::Vector3d along_W = (X_WH.translation() - from_W).normalized();
  for (const auto& q : trajectory.positions) {
    const Eigen::Vector3d off_W = robot_.HandPose(q).translation() - from_W;
    EXPECT_LT((off_W - off_W.dot(along_W) * along_W).norm(), 0.001);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, Timing, ::testing::Range(0, 20));

// One joint from rest to rest over d takes d / v + v / a if it reaches its speed, plus the moving
// mean.
TEST(TimingOfOneJoint, TakesTheTimeOfATrapezoid) {
  const Robot robot = Robot::Load(SmallCell());
  for (int joint = 0; joint < robot.dof(); ++joint) {
    Eigen::VectorXd goal = Eigen::VectorXd::Zero(robot.dof());
    goal[joint] = 1.0;
    const double v = robot.velocity[joint];
    const double a = robot.acceleration[joint];
    const auto trajectory = TimeParameterise(robot, {Eigen::VectorXd::Zero(robot.dof()), goal}, {});
    // Speed changes only at grid points, 0.01 rad apart: up to 0.01 / v at each ramp. Filling the
    // last period adds up to two samples.
    const double expected = 1.0 / v + v / a + TimingOptions().smoothing_s;
    EXPECT_GE(trajectory.Duration(), expected - 0.01);
    EXPECT_LE(trajectory.Duration(), expected + 2.0 * 0.01 / v + 0.02);
  }
}

// A rounded corner is passed without a stop.
TEST(TimingOfCorners, RoundingSavesTime) {
  const Robot robot = Robot::Load(SmallCell());
  Path path(3, Eigen::VectorXd::Zero(robot.dof()));
  path[1][0] = path[2][0] = 1.0;
  path[2][1] = 1.0;
  const double sharp = TimeParameterise(robot, path, {.corner_rad = 0.0}).Duration();
  const double rounded = TimeParameterise(robot, path, {.corner_rad = 0.05}).Duration();
  EXPECT_LT(rounded, sharp - 0.02);
}

TEST(TimingOfCorners, ReversalsAndRepeatedPointsStopThereAndKeepTheLimits) {
  const Robot robot = Robot::Load(SmallCell());
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(robot.dof());
  const Eigen::VectorXd one = Eigen::VectorXd::Constant(robot.dof(), 0.5);
  const auto there_and_back = TimeParameterise(robot, {zero, one, one, zero}, {});
  ExpectWithinLimits(robot, there_and_back, {});
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& q : there_and_back.positions) nearest = std::min(nearest, (q - one).norm());
  EXPECT_LT(nearest, SmoothingDeviation(robot, {}));

  const auto nothing = TimeParameterise(robot, {one, one}, {});
  EXPECT_EQ(nothing.positions, Path{one});
}

using Eigen::VectorXd;

VectorXd At(double x, double y) { return Eigen::Vector2d(x, y); }

// At a right angle, the arc of radius r is r (sqrt 2 - 1) from the corner and cuts r off both legs.
TEST(RoundCorners, RightAngleHasTheAnalyticArc) {
  const double corner_rad = 0.05;
  const double r = corner_rad / (std::sqrt(2.0) - 1.0);
  const auto pieces = RoundCorners({At(0, 0), At(1, 0), At(1, 2)}, corner_rad);
  ASSERT_EQ(pieces.size(), 3u);
  EXPECT_NEAR(pieces[0].length, 1.0 - r, 1e-12);
  EXPECT_NEAR(pieces[1].length, 0.5 * base::kPi * r, 1e-12);
  EXPECT_NEAR(pieces[2].length, 2.0 - r, 1e-12);
  const VectorXd middle = pieces[1].Position(0.5 * pieces[1].length);
  EXPECT_NEAR((middle - At(1, 0)).norm(), corner_rad, 1e-12);
}

// If a leg is too short for the arc, at most half of it is cut.
TEST(RoundCorners, ShortLegsAreCutByHalfAtMost) {
  const auto pieces = RoundCorners({At(0, 0), At(0.02, 0), At(0.02, 1)}, 0.05);
  ASSERT_EQ(pieces.size(), 3u);
  EXPECT_NEAR(pieces[0].length, 0.01, 1e-12);
}

TEST(RoundCorners, ReversalsStopAndStraightOrRepeatedPointsDoNot) {
  const auto reversal = RoundCorners({At(0, 0), At(1, 0), At(0.2, 0)}, 0.05);
  ASSERT_EQ(reversal.size(), 2u);
  EXPECT_FALSE(reversal[0].stop_before);
  EXPECT_TRUE(reversal[1].stop_before);
  const auto straight = RoundCorners({At(0, 0), At(1, 0), At(1, 0), At(3, 0)}, 0.05);
  double length = 0.0;
  for (const PathPiece& piece : straight) {
    length += piece.length;
    EXPECT_FALSE(piece.stop_before);
    EXPECT_EQ(piece.radius, 0.0);
  }
  EXPECT_NEAR(length, 3.0, 1e-12);
  EXPECT_TRUE(RoundCorners({At(1, 1), At(1, 1)}, 0.05).empty());
}

// In seven dimensions: each piece starts where the previous one ends, in the same direction; the
// derivatives match differences of the position; no point is further than corner_rad from the
// polyline.
TEST(RoundCorners, RandomPathsAreSmoothAndNear) {
  base::Rng rng(3);
  for (int n = 0; n < 200; ++n) {
    std::vector<VectorXd> points;
    for (int i = 0; i < 5; ++i) {
      VectorXd q(7);
      for (double& value : q) value = rng.Uniform(-1.0, 1.0);
      points.push_back(q);
    }
    const auto pieces = RoundCorners(points, 0.05);
    EXPECT_LT((pieces.front().Position(0.0) - points.front()).norm(), 1e-12);
    EXPECT_LT((pieces.back().Position(pieces.back().length) - points.back()).norm(), 1e-9);
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      const PathPiece& piece = pieces[k];
      if (k > 0 && !piece.stop_before) {
        const PathPiece& last = pieces[k - 1];
        EXPECT_LT((last.Position(last.length) - piece.Position(0.0)).norm(), 1e-9);
        EXPECT_LT((last.Tangent(last.length) - piece.Tangent(0.0)).norm(), 1e-6);
      }
      const double s = 0.37 * piece.length;
      const double h = 1e-5 * piece.length;
      const VectorXd slope = (piece.Position(s + h) - piece.Position(s - h)) / (2.0 * h);
      const VectorXd bend = (piece.Tangent(s + h) - piece.Tangent(s - h)) / (2.0 * h);
      EXPECT_LT((slope - piece.Tangent(s)).norm(), 1e-6);
      EXPECT_LT((bend - piece.Curvature(s)).norm(), 1e-6 * (1.0 + bend.norm()));
      EXPECT_NEAR(piece.Tangent(s).norm(), 1.0, 1e-12);
      double distance = 1e9;
      for (std::size_t i = 1; i < points.size(); ++i) {
        const VectorXd leg = points[i] - points[i - 1];
        const double t =
            std::clamp((piece.Position(s) - points[i - 1]).dot(leg) / leg.squaredNorm(), 0.0, 1.0);
        distance = std::min(distance, (piece.Position(s) - points[i - 1] - t * leg).norm());
      }
      EXPECT_LE(distance, 0.05 + 1e-12);
    }
  }
}

}  // namespace
}  // namespace rangegrasp::robot
