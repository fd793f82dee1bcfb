#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "robot/internal/ik_solver.h"

namespace rangegrasp::robot {
namespace {

constexpr double kLargestJump_rad = 0.2;  ///< a joint, from one pose to the next
constexpr double kNullSpaceStep_rad = 0.02;

/// A step away from the limits that leaves the hand where it is (to first order): the descent of
/// sum ((q - middle) / half range)^6 within the null space of the Jacobian. It hardly acts in the
/// middle of the range, so that paths stay short.
Eigen::VectorXd NullSpaceStep(const Robot& robot, const Eigen::VectorXd& q) {
  const Eigen::ArrayXd half = 0.5 * (robot.upper - robot.lower).array();
  const Eigen::ArrayXd share = (q - 0.5 * (robot.upper + robot.lower)).array() / half;
  const Eigen::VectorXd descent = -kNullSpaceStep_rad * share.pow(5);
  const Eigen::MatrixXd J = robot.HandJacobian(q);
  Eigen::Matrix<double, 6, 6> A = 1e-9 * Eigen::Matrix<double, 6, 6>::Identity();
  A.noalias() += J * J.transpose();
  return descent - J.transpose() * A.llt().solve(J * descent);
}

}  // namespace

std::optional<std::vector<Eigen::VectorXd>> FollowPoses(const Robot& robot,
                                                        const Eigen::VectorXd& q_start,
                                                        const std::vector<core::Pose>& poses_WH) {
  const internal::IkTolerance tolerance{1e-6, 1e-5, 20};
  std::vector<Eigen::VectorXd> path;
  path.reserve(poses_WH.size());
  Eigen::VectorXd q = q_start;
  for (const core::Pose& X_WH : poses_WH) {
    Eigen::VectorXd next =
        (q + NullSpaceStep(robot, q)).cwiseMax(robot.lower).cwiseMin(robot.upper);
    if (!internal::RefineIk(robot, X_WH, robot.lower, robot.upper, tolerance, next)) return {};
    if ((next - q).cwiseAbs().maxCoeff() > kLargestJump_rad) return {};
    path.push_back(next);
    q = next;
  }
  return path;
}

std::optional<std::vector<Eigen::VectorXd>> StraightLine(const Robot& robot,
                                                         const Eigen::VectorXd& q_start,
                                                         const core::Pose& X_WH, double step_m) {
  const core::Pose X_start = robot.HandPose(q_start);
  const Eigen::Quaterniond from(X_start.linear());
  const Eigen::Quaterniond to(X_WH.linear());
  const Eigen::Vector3d way = X_WH.translation() - X_start.translation();
  const double length = std::max(way.norm(), 0.25 * from.angularDistance(to));
  const int steps = std::max(1, static_cast<int>(std::ceil(length / step_m)));
  std::vector<core::Pose> poses;
  for (int i = 1; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    poses.push_back(
        core::MakePose(from.slerp(t, to).toRotationMatrix(), X_start.translation() + t * way));
  }
  auto path = FollowPoses(robot, q_start, poses);
  if (path) path->insert(path->begin(), q_start);
  return path;
}

}  // namespace rangegrasp::robot
