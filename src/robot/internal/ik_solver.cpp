#include "robot/internal/ik_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

namespace rangegrasp::robot::internal {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// The joints' longest step in one iteration (the largest joint). Beyond it the linearisation says
/// little; larger: wild starts leave the branch they were drawn on, smaller: more iterations.
constexpr double kMaxStep_rad = 0.6;
/// [m^2] keeps the system solvable where the Jacobian is singular and the error is nearly zero.
constexpr double kMinDamping_m2 = 1e-8;
/// A start is given up when over so many iterations ...
constexpr int kPatience = 8;
/// ... its squared error did not fall below this share: it is stuck at the limits. Larger: time
/// goes into starts that end nowhere.
constexpr double kMinProgress = 0.7;

/// Position and rotation error (the rotation vector of R_target R^T) in W.
Vector6 PoseError(const base::Pose& X_target, const base::Pose& X) {
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

bool RefineIk(const Robot& robot, const base::Pose& X_WH, const Eigen::VectorXd& lower,
              const Eigen::VectorXd& upper, const IkTolerance& tolerance, Eigen::VectorXd& q) {
  Eigen::MatrixXd J;
  double checkpoint = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= tolerance.iterations; ++i) {
    Vector6 error = PoseError(X_WH, robot.HandPoseAndJacobian(q, J));
    if (error.head<3>().norm() <= tolerance.position_m &&
        error.tail<3>().norm() <= tolerance.rotation_rad) {
      return true;
    }
    error.tail<3>() *= kRotationRadius_m;
    J.bottomRows<3>() *= kRotationRadius_m;
    const double cost = error.squaredNorm();
    if (i % kPatience == kPatience - 1) {
      if (cost > kMinProgress * checkpoint) return false;
      checkpoint = cost;
    }
    Eigen::VectorXd dq = Step(J, error, 0.5 * cost + kMinDamping_m2, q, lower, upper);
    const double max_step = dq.cwiseAbs().maxCoeff();
    if (max_step > kMaxStep_rad) dq *= kMaxStep_rad / max_step;
    q = (q + dq).cwiseMax(lower).cwiseMin(upper);
  }
  return false;
}

}  // namespace rangegrasp::robot::internal
