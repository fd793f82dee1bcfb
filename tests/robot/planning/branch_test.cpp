#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "robot/ik.h"
#include "robot/planning/internal/motions.h"
#include "robot/test_cells.h"

namespace rangegrasp::planning::internal {
namespace {

using Eigen::Vector3d;

/// The object and its delivery place are a quarter turn apart, 0.4 m and 0.6 m from the base.
Task QuarterTurn() {
  Task task;
  task.X_WH = base::MakePose(Eigen::AngleAxisd(0.3, Vector3d::UnitX()).toRotationMatrix(),
                             Vector3d(0.5, 0.2, 0.4));
  task.base_W = Vector3d(0.1, 0.2, 0.3);
  task.center_W = Vector3d(0.5, 0.2, 0.05);
  task.delivered_W = Vector3d(0.1, 0.8, 0.08);
  task.lift_m = 0.2;
  return task;
}

TEST(DeliveryYaws, StartWithTheTurnRoundTheBaseAndAlternate) {
  const auto yaws = DeliveryYaws(QuarterTurn(), 6);
  const double quarter = 0.5 * base::kPi;
  const double sixth = base::kPi / 3.0;
  ASSERT_EQ(yaws.size(), 6u);
  for (const auto& [k, offset] :
       {std::pair{0u, 0.0}, {1u, 1.0}, {2u, -1.0}, {3u, 2.0}, {4u, -2.0}}) {
    EXPECT_NEAR(std::remainder(yaws[k] - quarter - offset * sixth, 2.0 * base::kPi), 0.0, 1e-12);
  }
  for (const double yaw : yaws) EXPECT_LE(std::abs(yaw), base::kPi + 1e-12);
}

// The object's center moves around the base. The angle and the distance grow in proportion, the
// height stays at the lifted height, and the hand rotates only about the vertical.
TEST(CarryPose, TakesTheObjectRoundTheBase) {
  const Task task = QuarterTurn();
  const Vector3d center_H = task.X_WH.inverse() * task.center_W;
  const double yaw = 1.1;
  for (const double t : {0.0, 0.25, 0.5, 1.0}) {
    const base::Pose X_WH = CarryPose(task, yaw, t, 0.2);
    const double angle = t * 0.5 * base::kPi;
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

/// Two joints from 0 to 1 with a wall at 0.45 < x < 0.55 that is open for y > 0.8.
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
  // States are checked every 0.04 rad, so a corner may be cut by at most half of that.
  const auto core_is_free = [](const Eigen::VectorXd& q) {
    return q[0] < 0.47 || q[0] > 0.53 || q[1] > 0.78;
  };
  // Around both corners of the gap.
  const double shortest = 2.0 * std::hypot(0.35, 0.7) + 0.1;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    base::Rng rng(seed);
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
  base::Rng rng(1);
  wall.query.start = Eigen::Vector2d(0.1, 0.9);
  wall.query.goal = Eigen::Vector2d(0.9, 0.9);
  EXPECT_EQ(PlanJointPath(wall.robot, wall.query, rng)->size(), 2u);
  wall.query.iterations = 200;
  wall.query.free = [](const Eigen::VectorXd& q) { return q[0] < 0.45 || q[0] > 0.55; };
  EXPECT_FALSE(PlanJointPath(wall.robot, wall.query, rng));
  wall.query.goal = Eigen::Vector2d(0.5, 0.5);
  EXPECT_FALSE(PlanJointPath(wall.robot, wall.query, rng)) << "the goal is not free";
}

geometry::TriangleMesh BoxMesh(const Vector3d& center_W, const Vector3d& half) {
  geometry::Shape shape;
  shape.kind = geometry::Shape::Kind::kBox;
  shape.size = half;
  shape.X_BS.translation() = center_W;
  return geometry::Tessellate(shape);
}

/// The robot with the hand pointing down, the midpoint of its pads 250 mm above the workspace, and
/// a block there.
class InCell : public ::testing::TestWithParam<std::filesystem::path> {
 protected:
  InCell() {
    base::Rng rng(5);
    base::Pose X_WG = robot_.X_WWorkspace;
    X_WG.linear() = Vector3d(1.0, -1.0, -1.0).asDiagonal();
    X_WG.translation().z() = 0.25;
    center_W_ = X_WG.translation();
    q_ =
        robot::SolveIk(robot_, X_WG * robot_.hand().X_HG_tip.inverse(), robot_.home, {}, rng).at(0);
    scene_.target_W = BoxMesh(center_W_, kHalf);
    request_.X_WH = robot_.HandPose(q_);
    request_.approach_W = Vector3d(0.0, 0.0, -2.0);
    request_.opening_m = robot_.hand().MaxGap();
    request_.closed_gap_m = 0.03;
  }
  void Place() {
    check_.collider().SetScene(scene_.table_z_m, scene_.obstacles_W, scene_.target_W);
  }
  Task Make() { return MakeTask(robot_, scene_, request_, options_, check_.collider()); }
  bool Lifts(const std::vector<geometry::TriangleMesh>& obstacles_W) {
    scene_.obstacles_W = obstacles_W;
    Place();
    const Task task = Make();
    Branch branch;
    branch.q_grasp = q_;
    return BranchBuilder(robot_, options_, check_, task).Lift(branch);
  }

  const Vector3d kHalf{0.015, 0.015, 0.06};
  robot::Robot robot_ = robot::Robot::Load(GetParam());
  PlanOptions options_;
  MotionCheck check_{robot_, 0.0};
  Eigen::VectorXd q_;
  Vector3d center_W_;
  PlanningScene scene_;
  PickRequest request_;
};

TEST_P(InCell, ATaskIsTheRequestAndTheMiddleOfTheObject) {
  const Task task = Make();
  EXPECT_EQ(task.X_WH.matrix(), request_.X_WH.matrix());
  EXPECT_LT((task.center_W - center_W_).norm(), 1e-12);
  EXPECT_LT((task.approach_W + Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_EQ(task.base_W, robot_.links().front().X_PB.translation());
  EXPECT_EQ(task.open_state, robot_.hand().IndexAtGap(request_.opening_m));
  EXPECT_EQ(task.closed_state, robot_.hand().IndexAtGap(request_.closed_gap_m));
  EXPECT_NE(task.open_state, task.closed_state);
  EXPECT_EQ(task.approach_m, options_.approach_m);
  EXPECT_EQ(task.lift_m, options_.lift_m);
  EXPECT_EQ(task.delivered_W.head<2>(), robot_.X_WDelivery.translation().head<2>());
  scene_.target_W = {};
  EXPECT_EQ(Make().center_W, request_.X_WH.translation()) << "of nothing: the hand";
}

// The object moves down until it or the hand, open or closed, has only its clearance to the table.
TEST_P(InCell, ADeliveryIsAsLowAsObjectAndHandAllow) {
  const auto lowest = [&](double gap_m) {
    return check_.collider().LowestOfHand(request_.X_WH, robot_.hand().IndexAtGap(gap_m));
  };
  const double hand = std::min(lowest(request_.opening_m), lowest(request_.closed_gap_m));
  const double object = center_W_.z() - kHalf.z();
  const auto drop = [&](double table_z_m) {
    scene_.table_z_m = table_z_m;
    return center_W_.z() + options_.lower_clearance_m - Make().delivered_W.z();
  };
  ASSERT_LT(object, hand - 0.004);
  EXPECT_NEAR(drop(object - 0.1), 0.1, 1e-9);
  EXPECT_NEAR(drop(object + 0.01), 0.0, 1e-9) << "it does not go up";
  // With a short object high in the hand, the hand's clearance of 4 mm ends the downward motion.
  scene_.target_W = BoxMesh(center_W_ + Vector3d(0.0, 0.0, 0.05), Vector3d::Constant(0.01));
  center_W_.z() += 0.05;
  EXPECT_NEAR(drop(hand - 0.104), 0.1, 1e-9);
  EXPECT_NEAR(drop(hand - 0.003), 0.0, 1e-9);
  // The longer of the closed and the open hand counts.
  std::swap(request_.opening_m, request_.closed_gap_m);
  EXPECT_NEAR(drop(hand - 0.104), 0.1, 1e-9);
}

TEST_P(InCell, ACarryHoldsTheObjectUprightAndMayTouchNothing) {
  // One obstacle is at the object's place during the grasp, the other where the lift ends.
  const Vector3d lift(0.0, 0.0, 0.2);
  request_.X_WH.translation() -= lift;
  scene_.target_W = BoxMesh(center_W_ - lift, kHalf);
  scene_.obstacles_W = {BoxMesh(center_W_ - lift, kHalf), BoxMesh(center_W_, kHalf)};
  Place();
  const Task task = Make();
  const Stage stage = BranchBuilder(robot_, options_, check_, task).CarryStage(robot_.home);
  EXPECT_TRUE(stage.contacts.held_ignores.empty());
  EXPECT_EQ(stage.contacts.target, collision::Contacts::Target::kHeld);
  EXPECT_EQ(stage.contacts.hand_state, task.closed_state);
  EXPECT_FALSE(stage.contacts.hand_margin);
  EXPECT_FALSE(stage.contacts.may_touch_table);
  EXPECT_LT((task.X_WH * stage.contacts.X_HT * task.center_W - task.center_W).norm(), 1e-12);
  EXPECT_LT((task.X_WH.linear() * stage.up_H - Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(stage.min_upright, std::cos(options_.carry_tilt_rad));
  const Stage reach = BranchBuilder(robot_, options_, check_, task).ReachStage();
  EXPECT_EQ(reach.contacts.hand_state, task.open_state);
  EXPECT_TRUE(reach.contacts.hand_margin);
  EXPECT_EQ(reach.contacts.target, collision::Contacts::Target::kObstacle);
  EXPECT_FALSE(reach.contacts.may_touch_table);
  EXPECT_LT(reach.min_upright, -0.99);
}

TEST_P(InCell, ALiftMayTouchTheTableAndWhatTheObjectTouchedAndNothingElse) {
  options_.lift_m = 0.03;
  scene_.table_z_m = center_W_.z() - kHalf.z() + 0.001;
  EXPECT_TRUE(Lifts({}));
  const Vector3d aside(0.0, 0.0, -kHalf.z() - 0.004);
  EXPECT_TRUE(Lifts({BoxMesh(center_W_ + aside, {0.01, 0.01, 0.005})})) << "it stood on it";
  // A plate under the hand hits a shelf 10 mm above it; a block passes the shelf.
  const geometry::TriangleMesh shelf =
      BoxMesh(center_W_ + Vector3d(0.09, 0.09, -0.065), {0.01, 0.01, 0.005});
  EXPECT_TRUE(Lifts({shelf}));
  scene_.target_W = BoxMesh(center_W_ - Vector3d(0.0, 0.0, 0.09), {0.1, 0.1, 0.01});
  EXPECT_FALSE(Lifts({shelf}));
  options_.lift_m = 0.009;
  EXPECT_TRUE(Lifts({shelf}));
}

// The object touches a post at the grasp. If the post ends below the object's upper half, the lift
// separates them. A ledge above is part of the same obstacle, but it blocks the lift, because the
// object reaches it after they have separated.
TEST_P(InCell, WhatTheObjectHasPartedFromIsInItsWay) {
  options_.lift_m = 0.05;
  const Vector3d side(kHalf.x() + 0.004, 0.0, 0.0);
  const geometry::TriangleMesh post =
      BoxMesh(center_W_ + side - Vector3d(0.0, 0.0, kHalf.z()), {0.005, 0.005, 0.004});
  EXPECT_TRUE(Lifts({post}));
  geometry::TriangleMesh bracket = post;
  geometry::Append(
      BoxMesh(center_W_ + side + Vector3d(0.0, 0.0, kHalf.z() + 0.03), {0.005, 0.005, 0.004}),
      bracket);
  EXPECT_FALSE(Lifts({bracket}));
}

TEST_P(InCell, JointsStayWithinTheirLimits) {
  Place();
  Stage stage;
  stage.contacts.target = collision::Contacts::Target::kGone;
  const robot::Robot limits = robot_;
  ASSERT_TRUE(check_.Free(q_, stage));
  for (Eigen::Index i = 0; i < q_.size(); ++i) {
    for (const double beyond : {0.0, 1e-9}) {
      robot_.upper[i] = q_[i] - beyond;
      EXPECT_EQ(check_.Free(q_, stage), beyond == 0.0) << i;
      robot_.upper = limits.upper;
      robot_.lower[i] = q_[i] + beyond;
      EXPECT_EQ(check_.Free(q_, stage), beyond == 0.0) << i;
      robot_.lower = limits.lower;
    }
  }
}

TEST_P(InCell, TheHandLeansNoFurtherThanTheStageAllows) {
  Place();
  Stage stage;
  stage.contacts.target = collision::Contacts::Target::kGone;
  stage.min_upright = std::cos(0.1);
  for (int k = 0; k < 12; ++k) {
    for (const double tilt : {0.0, 0.099, 0.101, 2.0, base::kPi}) {
      const Vector3d about(std::cos(k * base::kPi / 6), std::sin(k * base::kPi / 6), 0.0);
      const Vector3d up_W = Eigen::AngleAxisd(tilt, about) * Vector3d::UnitZ();
      stage.up_H = robot_.HandPose(q_).linear().transpose() * up_W;
      EXPECT_EQ(check_.Free(q_, stage), tilt < 0.1) << k << ' ' << tilt;
    }
  }
}

TEST_P(InCell, APathIsFreeAtItsFirstPointAndBetweenItsPoints) {
  Place();
  Stage stage;
  stage.contacts.target = collision::Contacts::Target::kGone;
  Eigen::VectorXd turned = q_;
  turned[q_.size() - 1] += 0.1;
  EXPECT_TRUE(check_.PathFree({q_, turned}, stage, 0.04));
  EXPECT_FALSE(check_.PathFree({}, stage, 0.04));
  robot_.upper[q_.size() - 1] = q_[q_.size() - 1] + 0.05;
  EXPECT_FALSE(check_.PathFree({turned, q_}, stage, 1.0)) << "its first point";
  EXPECT_FALSE(check_.PathFree({q_, turned}, stage, 1.0)) << "its last point";
  // Both ends are upright, but the leaning states in between are checked.
  robot_.upper[q_.size() - 1] = q_[q_.size() - 1] + 1.0;
  stage.min_upright = std::cos(0.05);
  Eigen::VectorXd far = q_;
  stage.up_H = robot_.HandPose(q_).linear().transpose() * Vector3d::UnitZ();
  far[1] += 2.0 * base::kPi;  // upright again after a full turn
  robot_.upper[1] = far[1] + 1.0;
  EXPECT_TRUE(check_.Free(far, stage));
  EXPECT_FALSE(check_.PathFree({q_, far}, stage, 0.04));
}

INSTANTIATE_TEST_SUITE_P(Cells, InCell, ::testing::ValuesIn(Cells()),
                         [](const auto& cell) { return CellName(cell.param); });

}  // namespace
}  // namespace rangegrasp::planning::internal
