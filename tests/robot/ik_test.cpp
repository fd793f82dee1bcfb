#include "robot/ik.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "robot/test_cells.h"

namespace rangegrasp::robot {
namespace {

class Ik : public ::testing::TestWithParam<std::filesystem::path> {
 protected:
  Ik() : robot_(Robot::Load(GetParam())) {}
  void ExpectSolves(const base::Pose& X_WH, const Eigen::VectorXd& q, const IkOptions& options) {
    const base::Pose X = robot_.HandPose(q);
    EXPECT_LE((X.translation() - X_WH.translation()).norm(), options.position_tolerance_m);
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(X.linear().transpose() * X_WH.linear()));
    // the angle of a rotation matrix is exact to about 1e-8
    EXPECT_LE(turn.angle(), options.rotation_tolerance_rad + 1e-7);
    EXPECT_TRUE((q.array() >= robot_.lower.array() + options.limit_margin_rad - 1e-12).all());
    EXPECT_TRUE((q.array() <= robot_.upper.array() - options.limit_margin_rad + 1e-12).all());
  }
  Robot robot_;
};

TEST_P(Ik, SolvesNearlyEveryReachablePoseWithinToleranceAndLimits) {
  base::Rng rng(11);
  IkOptions options;
  options.max_solutions = 1;
  int solved = 0;
  constexpr int kPoses = 1000;
  for (int n = 0; n < kPoses; ++n) {
    const base::Pose X_WH = robot_.HandPose(RandomJoints(robot_, rng));
    const auto solutions = SolveIk(robot_, X_WH, robot_.home, options, rng);
    solved += !solutions.empty();
    for (const auto& q : solutions) ExpectSolves(X_WH, q, options);
  }
  EXPECT_GE(solved, kPoses * 99 / 100);
}

TEST_P(Ik, GivesDistinctSolutionsNearestToTheSeedFirst) {
  base::Rng rng(12);
  IkOptions options;
  options.max_solutions = 6;
  int several = 0;
  for (int n = 0; n < 50; ++n) {
    const base::Pose X_WH = robot_.HandPose(RandomJoints(robot_, rng));
    const auto solutions = SolveIk(robot_, X_WH, robot_.home, options, rng);
    EXPECT_LE(solutions.size(), 6u);
    several += solutions.size() > 1 ? 1 : 0;
    for (std::size_t i = 0; i < solutions.size(); ++i) {
      ExpectSolves(X_WH, solutions[i], {});
      for (std::size_t k = 0; k < i; ++k) {
        EXPECT_GE((solutions[i] - solutions[k]).cwiseAbs().maxCoeff(), 0.05);
        EXPECT_GE((solutions[i] - robot_.home).norm(), (solutions[k] - robot_.home).norm());
      }
    }
  }
  EXPECT_GT(several, 25);
}

TEST_P(Ik, HasNoSolutionOutOfReach) {
  base::Rng rng(13);
  // The stretched arm is shorter than the sum of all offsets between its frames.
  double reach_m = robot_.X_FH.translation().norm();
  for (const Link& link : robot_.links()) {
    if (&link != &robot_.links().front()) reach_m += link.X_PB.translation().norm();
  }
  for (int n = 0; n < 50; ++n) {
    base::Pose X_WH = robot_.HandPose(RandomJoints(robot_, rng));
    const Eigen::Vector3d base_W = robot_.links().front().X_PB.translation();
    X_WH.translation() = base_W + (reach_m + 0.05) * (X_WH.translation() - base_W).normalized();
    EXPECT_TRUE(SolveIk(robot_, X_WH, robot_.home, {}, rng).empty());
  }
}

TEST_P(Ik, SameStreamSameBytes) {
  base::Rng draw(14);
  const base::Pose X_WH = robot_.HandPose(RandomJoints(robot_, draw));
  base::Rng a(5), b(5);
  EXPECT_EQ(SolveIk(robot_, X_WH, robot_.home, {}, a), SolveIk(robot_, X_WH, robot_.home, {}, b));
}

TEST_P(Ik, StraightLineStaysOnTheLineWithSmallSteps) {
  base::Rng rng(15);
  int lines = 0;
  for (int n = 0; n < 100; ++n) {
    const Eigen::VectorXd q0 = RandomJoints(robot_, rng, 0.3);
    const base::Pose X_0 = robot_.HandPose(q0);
    base::Pose X_1 = X_0;
    X_1.translation() += Eigen::Vector3d(rng.Uniform(-0.1, 0.1), rng.Uniform(-0.1, 0.1), 0.1);
    X_1.linear() =
        Eigen::AngleAxisd(rng.Uniform(-0.5, 0.5), Eigen::Vector3d::UnitZ()) * X_0.linear();
    const auto path = StraightLine(robot_, q0, X_1);
    if (!path) continue;
    ++lines;
    EXPECT_EQ(path->front(), q0);
    const Eigen::Vector3d way = X_1.translation() - X_0.translation();
    for (std::size_t i = 0; i < path->size(); ++i) {
      const double t = static_cast<double>(i) / static_cast<double>(path->size() - 1);
      const base::Pose X = robot_.HandPose((*path)[i]);
      EXPECT_LT((X.translation() - X_0.translation() - t * way).norm(), 1.1e-6);
      EXPECT_TRUE(((*path)[i].array() >= robot_.lower.array()).all());
      EXPECT_TRUE(((*path)[i].array() <= robot_.upper.array()).all());
      if (i == 0) continue;
      EXPECT_LE(((*path)[i] - (*path)[i - 1]).cwiseAbs().maxCoeff(), 0.2);
      // In between, the joint line deviates from the hand's line by about |d2x/dq2| dq^2 / 8. This
      // is below 1 mm for steps of 10 mm, except near singular poses, where one joint of an arm of
      // 0.8 m moves by up to 0.2 rad.
      const Eigen::VectorXd middle = 0.5 * ((*path)[i] + (*path)[i - 1]);
      const double t_mid = t - 0.5 / static_cast<double>(path->size() - 1);
      EXPECT_LT((robot_.HandPose(middle).translation() - X_0.translation() - t_mid * way).norm(),
                0.004);
    }
    const Eigen::AngleAxisd left(
        Eigen::Matrix3d(robot_.HandPose(path->back()).linear().transpose() * X_1.linear()));
    EXPECT_LT(left.angle(), 2e-5);
  }
  EXPECT_GT(lines, 30);  // many of these poses are stretched and their lines leave the reach
}

TEST_P(Ik, StraightLineOutOfReachIsRefused) {
  base::Pose X_WH = robot_.HandPose(robot_.home);
  X_WH.translation().x() += 3.0;
  EXPECT_FALSE(StraightLine(robot_, robot_.home, X_WH));
}

// A rotation in place has as many steps as the path of a point at kRotationRadius_m from the hand.
TEST_P(Ik, ATurnInPlaceIsALineOfSmallTurns) {
  base::Rng rng(16);
  int lines = 0;
  for (int n = 0; n < 100; ++n) {
    const Eigen::VectorXd q0 = RandomJoints(robot_, rng, 0.3);
    base::Pose X_WH = robot_.HandPose(q0);
    X_WH.linear() = X_WH.linear() * Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ());
    const auto path = StraightLine(robot_, q0, X_WH);
    if (!path) continue;
    ++lines;
    EXPECT_GE(path->size(), 1 + static_cast<std::size_t>(0.5 * kRotationRadius_m / 0.01));
  }
  EXPECT_GT(lines, 30);
}

// With the hand held in one place, the arm moves its elbow away from the joint limits.
TEST_P(Ik, FollowingAPoseLeavesTheLimits) {
  base::Rng rng(17);
  const Eigen::ArrayXd half = 0.5 * (robot_.upper - robot_.lower).array();
  const Eigen::ArrayXd middle = 0.5 * (robot_.upper + robot_.lower).array();
  const auto nearness = [&](const Eigen::VectorXd& q) {
    return ((q.array() - middle) / half).pow(6).sum();
  };
  int better = 0;
  int followed = 0;
  for (int n = 0; n < 50; ++n) {
    const Eigen::VectorXd q0 = RandomJoints(robot_, rng, 0.02);
    const auto path = FollowPoses(robot_, q0, std::vector<base::Pose>(40, robot_.HandPose(q0)));
    if (!path) continue;
    ++followed;
    better += nearness(path->back()) < nearness(q0);
  }
  EXPECT_GT(followed, 10);
  // To first order, the step is a descent step of this sum.
  EXPECT_GE(better, followed * 9 / 10);
}

INSTANTIATE_TEST_SUITE_P(Cells, Ik, ::testing::ValuesIn(AllCells()),
                         [](const auto& cell) { return CellName(cell.param); });

}  // namespace
}  // namespace rangegrasp::robot
