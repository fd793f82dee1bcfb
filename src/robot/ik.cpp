#include "robot/ik.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/linear_algebra.h"
#include "base/units.h"

namespace rangegrasp::robot {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Longest step of a joint in one iteration. With a larger one, distant starts leave their initial
/// branch; with a smaller one, more iterations are needed.
constexpr double kMaxStep_rad = 0.6;
/// [m^2] keeps the system solvable where the Jacobian is singular and the error is nearly zero.
constexpr double kMinDamping_m2 = 1e-8;
/// A start is given up, as stuck at the limits, if its squared error has not fallen below this
/// share over this many iterations.
constexpr int kPatience = 8;
constexpr double kMinProgress = 0.7;

/// Position and rotation error (the rotation vector of R_target R^T) in W.
Vector6 PoseError(const base::Pose& X_target, const base::Pose& X) {
  const Eigen::AngleAxisd turn = base::TurnOf(X_target.linear() * X.linear().transpose());
  Vector6 error;
  error << X_target.translation() - X.translation(), turn.angle() * turn.axis();
  return error;
}

/// dq = J^T (J J^T + damping I)^-1 e, repeated without the joints that would leave their limits.
VectorXd Step(MatrixXd& J, const Vector6& error, double damping, const VectorXd& q,
              const VectorXd& lower, const VectorXd& upper) {
  VectorXd dq;
  for (int pass = 0; pass < 2; ++pass) {
    Matrix6 A = damping * Matrix6::Identity();
    A.noalias() += J * J.transpose();
    dq = J.transpose() * base::SolveLlt(A, error);
    bool held = false;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      if ((q[i] >= upper[i] && dq[i] > 0.0) || (q[i] <= lower[i] && dq[i] < 0.0)) {
        J.col(i).setZero();
        held = true;
      }
    }
    if (!held) break;
  }
  return dq;
}

/// Levenberg-Marquardt from q towards X_WH inside [lower, upper]; q holds the result. Damping is
/// half the squared error (Sugihara 2011); joints that would leave their limits are held.
/// @return false if the tolerance was not met or the error stalled.
bool RefineIk(const Robot& robot, const base::Pose& X_WH, const VectorXd& lower,
              const VectorXd& upper, const IkOptions& options, VectorXd& q) {
  MatrixXd J;
  double checkpoint = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= options.iterations; ++i) {
    Vector6 error = PoseError(X_WH, robot.HandPoseAndJacobian(q, J));
    if (error.head<3>().norm() <= options.position_tolerance_m &&
        error.tail<3>().norm() <= options.rotation_tolerance_rad) {
      return true;
    }
    error.tail<3>() *= kRotationRadius_m;
    J.bottomRows<3>() *= kRotationRadius_m;
    const double cost = error.squaredNorm();
    if (i % kPatience == kPatience - 1) {
      if (cost > kMinProgress * checkpoint) return false;
      checkpoint = cost;
    }
    VectorXd dq = Step(J, error, 0.5 * cost + kMinDamping_m2, q, lower, upper);
    const double max_step = dq.cwiseAbs().maxCoeff();
    if (max_step > kMaxStep_rad) dq *= kMaxStep_rad / max_step;
    q = (q + dq).cwiseMax(lower).cwiseMin(upper);
  }
  return false;
}

/// Shifts each angle by whole turns to the value nearest to the seed's, within the limits.
void Unwind(const VectorXd& seed, const VectorXd& lower, const VectorXd& upper, VectorXd& q) {
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double turned = q[i] + 2.0 * base::kPi * std::round((seed[i] - q[i]) / (2.0 * base::kPi));
    if (turned >= lower[i] && turned <= upper[i]) q[i] = turned;
  }
}

/// A joint that moves further from one pose to the next has changed its branch, or passes a
/// singularity.
constexpr double kMaxJump_rad = 0.2;
/// Null space step at a joint limit. If larger, the limit is left sooner but the elbow turns more.
constexpr double kNullSpaceStep_rad = 0.02;
/// Few iterations: near the solution, each one about doubles the number of digits.
constexpr IkOptions kFollow{
    .iterations = 20, .position_tolerance_m = 1e-6, .rotation_tolerance_rad = 1e-5};
/// [m^2] keeps J J^T invertible at singular poses; 1e-9 of its entries' order of 0.1 to 1.
constexpr double kRegularisation_m2 = 1e-9;

/// A step away from the limits that leaves the hand where it is (to first order): the descent of
/// sum ((q - middle) / half range)^6 within the null space of the Jacobian. It hardly acts in the
/// middle of the range, so that paths stay short.
VectorXd NullSpaceStep(const Robot& robot, const VectorXd& q) {
  const Eigen::ArrayXd half = 0.5 * (robot.upper - robot.lower).array();
  const Eigen::ArrayXd share = (q - 0.5 * (robot.upper + robot.lower)).array() / half;
  const VectorXd descent = -kNullSpaceStep_rad * share.pow(5);
  MatrixXd J;
  robot.HandPoseAndJacobian(q, J);
  Matrix6 A = kRegularisation_m2 * Matrix6::Identity();
  A.noalias() += J * J.transpose();
  return descent - J.transpose() * base::SolveLlt(A, J * descent);
}

}  // namespace

std::vector<VectorXd> SolveIk(const Robot& robot, const base::Pose& X_WH, const VectorXd& seed,
                              const IkOptions& options, base::Rng& rng) {
  const VectorXd lower = robot.lower.array() + options.limit_margin_rad;
  const VectorXd upper = robot.upper.array() - options.limit_margin_rad;
  std::vector<VectorXd> solutions;
  for (int start = 0; start <= options.starts && solutions.size() < options.max_solutions;
       ++start) {
    VectorXd q = seed.cwiseMax(lower).cwiseMin(upper);
    for (Eigen::Index i = 0; start > 0 && i < q.size(); ++i) q[i] = rng.Uniform(lower[i], upper[i]);
    if (!RefineIk(robot, X_WH, lower, upper, options, q)) continue;
    Unwind(seed, lower, upper, q);
    const bool known = std::ranges::any_of(solutions, [&](const auto& other) {
      return (other - q).cwiseAbs().maxCoeff() < options.distinct_rad;
    });
    if (!known) solutions.push_back(q);
  }
  std::ranges::stable_sort(solutions, [&](const auto& a, const auto& b) {
    return (a - seed).squaredNorm() < (b - seed).squaredNorm();
  });
  return solutions;
}

std::optional<std::vector<VectorXd>> FollowPoses(const Robot& robot, const VectorXd& q_start,
                                                 const std::vector<base::Pose>& poses_WH) {
  std::vector<VectorXd> path;
  path.reserve(poses_WH.size());
  VectorXd q = q_start;
  for (const base::Pose& X_WH : poses_WH) {
    VectorXd next = (q + NullSpaceStep(robot, q)).cwiseMax(robot.lower).cwiseMin(robot.upper);
    if (!RefineIk(robot, X_WH, robot.lower, robot.upper, kFollow, next)) return {};
    if ((next - q).cwiseAbs().maxCoeff() > kMaxJump_rad) return {};
    path.push_back(next);
    q = next;
  }
  return path;
}

std::optional<std::vector<VectorXd>> StraightLine(const Robot& robot, const VectorXd& q_start,
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
