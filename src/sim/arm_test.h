#pragma once

#include <Eigen/Core>

#include "base/trajectory.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// What an arm does that is to stay where it is.
struct HoldReport {
  double drift_m = 0.0;     ///< largest way of the hand's root body from where it began
  Eigen::VectorXd sag_rad;  ///< largest of each joint from its command
};

/// Commands the arm to stay at its present positions for a time, its hand without force.
/// @throws base::InputError if the scene has no arm or no hand
HoldReport HoldStill(World& world, double duration_s);

/// Sends the arm along a trajectory from where it stands, as a trial does.
/// @return how far each joint was behind at most [rad] (as a trial counts it)
Eigen::VectorXd LagBehind(World& world, const base::JointTrajectory& trajectory);

}  // namespace rangegrasp::sim
