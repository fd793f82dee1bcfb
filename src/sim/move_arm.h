#pragma once

#include "base/frames.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// What came of a motion of the arm that nothing should be in the way of.
struct MoveLog {
  bool arrived = false;      ///< if not, the drives felt something, and the arm stands where it was
  double lag_rad = 0.0;      ///< largest, of a joint behind its command
  double simulated_s = 0.0;  ///< with the rest at the end
};

/// Sends the arm along a trajectory from where it stands by its servos alone, the hand without
/// force, and waits until it rests: what it looks from then does not move. Ends where a joint falls
/// behind as it does where something is in the way.
/// @throws base::InputError if the scene has no arm
MoveLog MoveArm(World& world, const base::JointTrajectory& trajectory);

}  // namespace rangegrasp::sim
