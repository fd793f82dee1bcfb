#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <vector>

#include "base/frames.h"

namespace rangegrasp::sim::internal {

/// A trajectory's position and velocity at a time; positions are linear between samples, velocities
/// (central differences at the samples) too, so that the drives see no staircase.
struct JointCommand {
  Eigen::VectorXd position, velocity;
};
JointCommand CommandAt(const base::JointTrajectory& trajectory, double time_s);
JointCommand StayAt(const Eigen::VectorXd& position);

/// The arm's position servos. The reference velocity is fed forward against the servo's own
/// damping: control = reference + (kv + damping) / kp * reference velocity.
class ArmServo {
 public:
  /// @throws base::InputError if a tuple is missing, or they differ in length
  explicit ArmServo(const mjModel* model);
  void Command(const mjModel* model, mjData* data, const JointCommand& command) const;
  const std::vector<int>& joints() const { return joints_; }
  const std::vector<int>& actuators() const { return actuators_; }
  /// Whether the drive of joint number i gives all that it has.
  bool AtLimit(const mjModel* model, const mjData* data, std::size_t i) const;
  /// Moves a command towards where the joints are, so that no drive gives more than a share of what
  /// it has: gravity's part of it counts, too.
  void GiveWay(const mjModel* model, const mjData* data, double share,
               Eigen::VectorXd& position) const;
  /// What the drives give [Nm, N].
  Eigen::VectorXd Torques(const mjModel* model, const mjData* data) const;
  /// Of a point that moves with a body, by the arm's joints: p_W' = J q'.
  Eigen::Matrix3Xd Jacobian(const mjModel* model, const mjData* data, int body,
                            const Eigen::Vector3d& point_W) const;
  /// How far each joint is from its command [rad, m]. The servo sees a joint as it was a step ago:
  /// ahead by what it moves in a step (6 mrad of 3 rad/s) is no error.
  Eigen::VectorXd Lags(const mjModel* model, const mjData* data, const JointCommand& command) const;
  double TrackingError(const mjModel* model, const mjData* data,
                       const JointCommand& command) const {
    return Lags(model, data, command).maxCoeff();
  }

 private:
  std::vector<int> joints_, actuators_;
};

}  // namespace rangegrasp::sim::internal
