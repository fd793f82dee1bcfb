#include "robot/straight_line.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "robot/internal/ik_solver.h"

namespace rangegrasp::robot {
namespace {

/// [m^2] keeps J J^T invertible at singular poses; 1e-9 of its entries' order of 0.1 to 1.
constexpr double kRegularisation_m2 = 1e-9;

/// A step away from the limits that leaves the hand where it is (to first order): the descent of
/// sum ((q - middle) / half range)^6 within the null space of the Jacobian. It hardly acts in the
/// middle of the range, so that paths stay short.
Eigen::VectorXd NullSpaceStep(const Robot& robot, const Eigen::VectorXd& q, double step_rad) {
  const Eigen::ArrayXd half = 0.5 * (robot.upper - robot.lower).array();
  const Eigen::ArrayXd share = (q - 0.5 * (robot.upper + robot.lower)).array() / half;
  const Eigen::VectorXd descent = -step_rad * share.pow(5);
  const Eigen::MatrixXd J = robot.HandJacobian(q);
  Eigen::Matrix<double, 6, 6> A = kRegularisation_m2 * Eigen::Matrix<double, 6, 6>::Identity();
  A.noalias() += J * J.transpose();
  return descent - J.transpose() * A.llt().solve(J * descent);
}

}  // namespace

std::optional<std::vector<Eigen::VectorXd>> FollowPoses(const Robot& robot,
                                                        const Eigen::VectorXd& q_start,
                                                        const std::vector<base::Pose>& poses_WH,
                                                        const FollowOptions& options) {
  const internal::IkTolerance tolerance{options.position_tolerance_m,
                                        options.rotation_tolerance_rad, options.iterations};
  std::vector<Eigen::VectorXd> path;
  path.reserve(poses_WH.size());
  Eigen::VectorXd q = q_start;
  for (const base::Pose& X_WH : poses_WH) {
    Eigen::VectorXd next = (q + NullSpaceStep(robot, q, options.null_space_step_rad))
                               .cwiseMax(robot.lower)
                               .cwiseMin(robot.upper);
    if (!internal::RefineIk(robot, X_WH, robot.lower, robot.upper, tolerance, next)) return {};
    if ((next - q).cwiseAbs().maxCoeff() > options.max_jump_rad) return {};
    path.push_back(next);
    q = next;
  }
  return path;
}

std::optional<std::vector<Eigen::VectorXd>> StraightLine(const Robot& robot,
                                                         const Eigen::VectorXd& q_start,
                                                         const base::Pose& X_WH, double step_m) {
  const base::Pose X_start = robot.HandPose(q_start);
  const Eigen::Quaterniond from(X_start.linear());
  const Eigen::Quaterniond to(X_WH.linear());
  const Eigen::Vector3d way = X_WH.translation() - X_start.translation();
  const double length = std::max(way.norm(), kRotationRadius_m * from.angularDistance(to));
  const int steps = std::max(1, static_cast<int>(std::ceil(length / step_m)));
  std::vector<base::Pose> poses;
  for (int i = 1; i <= steps; ++i) {
    const double t = static_cast<double>(i) / steps;
    poses.push_back(
        base::MakePose(from.slerp(t, to).toRotationMatrix(), X_start.translation() + t * way));
  }
  auto path = FollowPoses(robot, q_start, poses);
  if (path) path->insert(path->begin(), q_start);
  return path;
}

}  // namespace rangegrasp::robot
