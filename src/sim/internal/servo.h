#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <vector>

#include "base/frames.h"

namespace rangegrasp::sim::internal {

/// Position and velocity of a trajectory at a time. Both are linear between samples (velocities are
/// central differences at the samples), so that the drives see no steps.
struct JointCommand {
  Eigen::VectorXd position, velocity;
};
JointCommand CommandAt(const base::JointTrajectory& trajectory, double time_s);
JointCommand StayAt(const Eigen::VectorXd& position);

/// Torque or force limit of a drive [Nm, N]: the lower one of the joint's and the actuator's limit,
/// mjMAXVAL if the model gives neither.
double DriveLimit(const mjModel* model, int joint, int actuator);

/// The arm's position servos. The reference velocity is fed forward against the servo's own
/// damping: control = reference + (kv + damping) / kp * reference velocity.
class ArmServo {
 public:
  /// @throws base::InputError if a tuple is missing, or they differ in length
  explicit ArmServo(const mjModel* model);
  void Command(mjData* data, const JointCommand& command) const;
  const std::vector<int>& joints() const { return joints_; }
  const std::vector<int>& actuators() const { return actuators_; }
  /// Whether the drive of joint number i is at its torque or force limit.
  bool AtLimit(const mjData* data, std::size_t i) const;
  /// Moves a command towards the present joint positions so that no drive gives more than a share
  /// of its limit, including the load of gravity.
  void GiveWay(const mjData* data, double share, Eigen::VectorXd& position) const;
  /// Torques or forces of the drives [Nm, N].
  Eigen::VectorXd Torques(const mjData* data) const;
  /// Distance of each joint from its command [rad, m]. The servo sees the joint's position of the
  /// step before, so a lead of up to one step's motion (6 mrad at 3 rad/s) is not an error.
  Eigen::VectorXd Lags(const mjData* data, const JointCommand& command) const;

 private:
  const mjModel* model_;
  std::vector<int> joints_, actuators_;
};

}  // namespace rangegrasp::sim::internal
