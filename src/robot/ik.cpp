#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

#include "robot/internal/ik_solver.h"

namespace rangegrasp::robot {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kRadianInMetres = 0.25;  ///< weight of the rotation: about the hand's length
constexpr double kLargestStep_rad = 0.6;
constexpr double kLeastDamping = 1e-8;

/// Position and rotation error (the rotation vector of R_target R^T) in W.
Vector6 PoseError(const core::Pose& X_target, const core::Pose& X) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(X_target.linear() * X.linear().transpose()));
  Vector6 error;
  error << X_target.translation() - X.translation(), turn.angle() * turn.axis();
  return error;
}

/// dq = J^T (J J^T + damping I)^-1 e, and once more without the joints that it would push out.
Eigen::VectorXd Step(Eigen::MatrixXd& J, const Vector6& error, double damping,
                     const Eigen::VectorXd& q, const Eigen::VectorXd& lower,
                     const Eigen::VectorXd& upper) {
  Eigen::VectorXd dq;
  for (int pass = 0; pass < 2; ++pass) {
    Matrix6 A = damping * Matrix6::Identity();
    A.noalias() += J * J.transpose();
    dq = J.transpose() * A.llt().solve(error);
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

}  // namespace

namespace internal {

bool RefineIk(const Robot& robot, const core::Pose& X_WH, const Eigen::VectorXd& lower,
              const Eigen::VectorXd& upper, const IkTolerance& tolerance, Eigen::VectorXd& q) {
  Eigen::MatrixXd J;
  double checkpoint = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= tolerance.iterations; ++i) {
    Vector6 error = PoseError(X_WH, robot.HandPoseAndJacobian(q, J));
    if (error.head<3>().norm() <= tolerance.position_m &&
        error.tail<3>().norm() <= tolerance.rotation_rad) {
      return true;
    }
    error.tail<3>() *= kRadianInMetres;
    J.bottomRows<3>() *= kRadianInMetres;
    const double cost = error.squaredNorm();
    if (i % 8 == 7) {
      if (cost > 0.7 * checkpoint) return false;
      checkpoint = cost;
    }
    Eigen::VectorXd dq = Step(J, error, 0.5 * cost + kLeastDamping, q, lower, upper);
    const double largest = dq.cwiseAbs().maxCoeff();
    if (largest > kLargestStep_rad) dq *= kLargestStep_rad / largest;
    q = (q + dq).cwiseMax(lower).cwiseMin(upper);
  }
  return false;
}

}  // namespace internal

std::vector<Eigen::VectorXd> SolveIk(const Robot& robot, const core::Pose& X_WH,
                                     const Eigen::VectorXd& seed, const IkOptions& options,
                                     core::Rng& rng, std::size_t most) {
  const Eigen::VectorXd lower = robot.lower.array() + options.limit_margin_rad;
  const Eigen::VectorXd upper = robot.upper.array() - options.limit_margin_rad;
  const internal::IkTolerance tolerance{options.position_tolerance_m,
                                        options.rotation_tolerance_rad, options.iterations};
  std::vector<Eigen::VectorXd> solutions;
  for (int start = 0; start <= options.starts && solutions.size() < most; ++start) {
    Eigen::VectorXd q = seed.cwiseMax(lower).cwiseMin(upper);
    for (Eigen::Index i = 0; start > 0 && i < q.size(); ++i) q[i] = rng.Uniform(lower[i], upper[i]);
    if (!internal::RefineIk(robot, X_WH, lower, upper, tolerance, q)) continue;
    const bool known = std::any_of(solutions.begin(), solutions.end(), [&](const auto& other) {
      return (other - q).cwiseAbs().maxCoeff() < 0.05;
    });
    if (!known) solutions.push_back(q);
  }
  std::stable_sort(solutions.begin(), solutions.end(), [&](const auto& a, const auto& b) {
    return (a - seed).squaredNorm() < (b - seed).squaredNorm();
  });
  return solutions;
}

}  // namespace rangegrasp::robot
