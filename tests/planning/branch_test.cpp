#include "planning/internal/branch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/units.h"
#include "planning/internal/joint_planner.h"

namespace rangegrasp::planning::internal {
namespace {

using Eigen::Vector3d;

/// An object a quarter turn away from its delivery place, at 0.4 m and 0.6 m from the base.
Task QuarterTurn() {
  Task task;
  task.X_WH = core::MakePose(Eigen::AngleAxisd(0.3, Vector3d::UnitX()).toRotationMatrix(),
                             Vector3d(0.5, 0.2, 0.4));
  task.base_W = Vector3d(0.1, 0.2, 0.3);
  task.center_W = Vector3d(0.5, 0.2, 0.05);
  task.delivered_W = Vector3d(0.1, 0.8, 0.08);
  task.lift_m = 0.2;
  return task;
}

TEST(DeliveryYaws, StartWithTheTurnRoundTheBaseAndAlternate) {
  const auto yaws = DeliveryYaws(QuarterTurn(), 6);
  const double quarter = 0.5 * core::kPi;
  const double sixth = core::kPi / 3.0;
  ASSERT_EQ(yaws.size(), 6u);
  for (const auto& [k, offset] :
       {std::pair{0u, 0.0}, {1u, 1.0}, {2u, -1.0}, {3u, 2.0}, {4u, -2.0}}) {
    EXPECT_NEAR(std::remainder(yaws[k] - quarter - offset * sixth, 2.0 * core::kPi), 0.0, 1e-12);
  }
  for (const double yaw : yaws) EXPECT_LE(std::abs(yaw), core::kPi + 1e-12);
}

// The object's middle goes round the base: the angle and the distance grow in proportion, the
// height is the lifted one, and the hand turns about the vertical alone.
TEST(CarryPose, TakesTheObjectRoundTheBase) {
  const Task task = QuarterTurn();
  const Vector3d center_H = task.X_WH.inverse() * task.center_W;
  const double yaw = 1.1;
  for (const double t : {0.0, 0.25, 0.5, 1.0}) {
    const core::Pose X_WH = CarryPose(task, yaw, t, 0.2);
    const double angle = t * 0.5 * core::kPi;
    const double radius = 0.4 + t * 0.2;
    const Vector3d expected = task.base_W + Vector3d(radius * std::cos(angle),
                                                     radius * std::sin(angle), 0.05 + 0.2 - 0.3);
    EXPECT_LT((X_WH * center_H - expected).norm(), 1e-12) << t;
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(t * yaw, Vector3d::UnitZ()).toRotationMatrix() * task.X_WH.linear();
    EXPECT_LT((X_WH.linear() - turn).norm(), 1e-12);
  }
}

TEST(EdgeFree, LooksAtEveryStepButTheFirstEnd) {
  std::vector<double> seen;
  const auto look = [&](const Eigen::VectorXd& q) {
    seen.push_back(q[0]);
    return true;
  };
  EXPECT_TRUE(EdgeFree(look, Eigen::VectorXd::Zero(1), Eigen::VectorXd::Ones(1), 0.3));
  ASSERT_EQ(seen.size(), 4u);  // 1 / 0.3, rounded up
  for (std::size_t i = 0; i < 4; ++i) EXPECT_DOUBLE_EQ(seen[i], 0.25 * static_cast<double>(i + 1));
  const auto blocked = [](const Eigen::VectorXd& q) { return q[0] < 0.5 || q[0] > 0.8; };
  EXPECT_FALSE(EdgeFree(blocked, Eigen::VectorXd::Zero(1), Eigen::VectorXd::Ones(1), 0.3));
}

/// Two joints, 0 to 1, with a wall at 0.45 < x < 0.55 that is open for y > 0.8.
struct WallWithAGap {
  WallWithAGap() {
    robot.lower = Eigen::VectorXd::Zero(2);
    robot.upper = Eigen::VectorXd::Ones(2);
    query.start = Eigen::Vector2d(0.1, 0.1);
    query.goal = Eigen::Vector2d(0.9, 0.1);
    query.free = [](const Eigen::VectorXd& q) { return q[0] < 0.45 || q[0] > 0.55 || q[1] > 0.8; };
  }
  robot::Robot robot;
  JointQuery query;
};

TEST(PlanJointPath, FindsTheGapInAWallAndIsShortenedToNearTheShortest) {
  WallWithAGap wall;
  // States are looked at every 0.04 rad: a corner may be cut by half of that, no more.
  const auto core_is_free = [](const Eigen::VectorXd& q) {
    return q[0] < 0.47 || q[0] > 0.53 || q[1] > 0.78;
  };
  // Round both corners of the gap.
  const double shortest = 2.0 * std::hypot(0.35, 0.7) + 0.1;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    core::Rng rng(seed);
    const auto path = PlanJointPath(wall.robot, wall.query, rng);
    ASSERT_TRUE(path) << seed;
    EXPECT_EQ(path->front(), wall.query.start);
    EXPECT_EQ(path->back(), wall.query.goal);
    double length = 0.0;
    for (std::size_t i = 1; i < path->size(); ++i) {
      length += ((*path)[i] - (*path)[i - 1]).norm();
      EXPECT_TRUE(EdgeFree(core_is_free, (*path)[i - 1], (*path)[i], 0.001)) << seed;
    }
    EXPECT_GT(length, shortest - 0.1);  // steps of 0.04 may cut both corners by that
    EXPECT_LT(length, 1.3 * shortest) << seed;
  }
}

TEST(PlanJointPath, GoesStraightWhereThatIsFreeAndGivesUpWhereNothingIs) {
  WallWithAGap wall;
  core::Rng rng(1);
  wall.query.start = Eigen::Vector2d(0.1, 0.9);
  wall.query.goal = Eigen::Vector2d(0.9, 0.9);
  EXPECT_EQ(PlanJointPath(wall.robot, wall.query, rng)->size(), 2u);
  wall.query.iterations = 200;
  wall.query.free = [](const Eigen::VectorXd& q) { return q[0] < 0.45 || q[0] > 0.55; };
  EXPECT_FALSE(PlanJointPath(wall.robot, wall.query, rng));
  wall.query.goal = Eigen::Vector2d(0.5, 0.5);
  EXPECT_FALSE(PlanJointPath(wall.robot, wall.query, rng)) << "the goal is not free";
}

}  // namespace
}  // namespace rangegrasp::planning::internal
