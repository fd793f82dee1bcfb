#include "sim/move_arm.h"

#include <algorithm>

#include "sim/internal/servo.h"

namespace rangegrasp::sim {
namespace {

// As in a grasp: the drives of a real arm would stop here.
constexpr double kWayBlocked_rad = 0.008;
// The arm lags by 3 mrad at the end of a motion at most, and its servos are critically damped.
constexpr double kSettle_s = 0.3;

}  // namespace

MoveLog MoveArm(World& world, const base::JointTrajectory& trajectory) {
  const internal::ArmServo servo(world.model());
  const double start_s = world.time_s();
  const double period_s = world.physics().timestep_s;
  MoveLog log;
  double lag_rad = 0.0;
  const auto step = [&](const internal::JointCommand& command) {
    servo.Command(world.model(), world.data(), command);
    world.Step();
    lag_rad = servo.TrackingError(world.model(), world.data(), command);
  };
  while (lag_rad <= kWayBlocked_rad && world.time_s() - start_s < trajectory.Duration()) {
    step(internal::CommandAt(trajectory, world.time_s() - start_s + period_s));
    log.lag_rad = std::max(log.lag_rad, lag_rad);
  }
  log.arrived = log.lag_rad <= kWayBlocked_rad;
  // Where it was stopped it pushes no longer.
  internal::JointCommand rest{log.arrived ? trajectory.positions.back() : world.ArmPositions(), {}};
  rest.velocity = Eigen::VectorXd::Zero(rest.position.size());
  for (const double rest_s = world.time_s(); world.time_s() - rest_s < kSettle_s;) step(rest);
  log.simulated_s = world.time_s() - start_s;
  return log;
}

}  // namespace rangegrasp::sim
