#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <vector>

#include "core/trajectory.h"

namespace rangegrasp::sim::internal {

/// A trajectory's position and velocity at a time; positions are linear between samples, velocities
/// (central differences at the samples) too, so that the drives see no staircase.
struct JointCommand {
  Eigen::VectorXd position, velocity;
};
JointCommand CommandAt(const core::JointTrajectory& trajectory, double time_s);

/// The arm's position servos. The reference velocity is fed forward against the servo's own
/// damping: control = reference + (kv + damping) / kp * reference velocity.
class ArmServo {
 public:
  explicit ArmServo(const mjModel* model);
  void Command(const mjModel* model, mjData* data, const JointCommand& command) const;
  /// Maximum of |torque| / limit over the arm's joints.
  double TorqueRatio(const mjModel* model, const mjData* data) const;

 private:
  std::vector<int> joints_, actuators_;
};

}  // namespace rangegrasp::sim::internal
