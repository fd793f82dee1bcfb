#include "sim/arm_test.h"

#include <algorithm>

#include "sim/internal/kinematics.h"
#include "sim/internal/names.h"
#include "sim/internal/servo.h"

namespace rangegrasp::sim {

HoldReport HoldStill(World& world, double duration_s) {
  const int hand = internal::Find(world.model(), mjOBJ_BODY, "hand");
  const internal::ArmServo servo(world.model());
  internal::JointCommand command;
  command.position = world.ArmPositions();
  command.velocity = Eigen::VectorXd::Zero(command.position.size());
  world.Refresh();
  const Eigen::Vector3d start_W = internal::BodyPose(world.data(), hand).translation();
  HoldReport report;
  report.sag_rad = command.velocity;
  const double end_s = world.time_s() + duration_s;
  while (world.time_s() < end_s) {
    servo.Command(world.model(), world.data(), command);
    world.Step();
    const Eigen::Vector3d now_W = internal::BodyPose(world.data(), hand).translation();
    // A drift that is no number is no small one.
    if (!((now_W - start_W).norm() <= report.drift_m)) report.drift_m = (now_W - start_W).norm();
    report.sag_rad = report.sag_rad.cwiseMax((world.ArmPositions() - command.position).cwiseAbs());
  }
  return report;
}

Eigen::VectorXd LagBehind(World& world, const base::JointTrajectory& trajectory) {
  const internal::ArmServo servo(world.model());
  Eigen::VectorXd lag = Eigen::VectorXd::Zero(world.ArmPositions().size());
  const double start_s = world.time_s();
  const double period_s = world.physics().timestep_s;
  while (world.time_s() - start_s < trajectory.Duration()) {
    const auto command = internal::CommandAt(trajectory, world.time_s() - start_s + period_s);
    servo.Command(world.model(), world.data(), command);
    world.Step();
    lag = lag.cwiseMax(servo.Lags(world.model(), world.data(), command));
  }
  return lag;
}

}  // namespace rangegrasp::sim
