#pragma once

#include <mujoco/mujoco.h>

#include <string_view>
#include <vector>

namespace rangegrasp::mjcf {

/// A drive of the hand: where what it moves stands in the open and in the closed hand. That is its
/// joint [rad or m], or its tendon, times its gear; closed may be the lower or the higher of both.
/// A drive whose two are equal holds its joint there.
struct HandMotor {
  int actuator = -1;
  double open = 0.0;
  double closed = 0.0;
  double Travel() const { return closed - open; }
  bool Moves() const { return closed != open; }
};

/// Whether the file says how the hand closes: tuple "hand_motors". A hand without it is one whose
/// hinges ("hand_joints", open at their lower limits) are closed by one geared "hand_motor".
bool HasMotors(const mjModel* model);

/// "hand_motors" with the numerics "hand_open" and "hand_closed", one value a drive.
/// @throws base::InputError naming what is missing, of another size, or a drive that is no motor
/// and no position servo (its force must be linear in command, length and speed).
std::vector<HandMotor> HandMotors(const mjModel* model);

/// The body that the thumb hangs on: that of the first of "hand_joints", or (HasMotors) the topmost
/// with a joint above the first of "fingertips". The pads below it face all others.
int ThumbRoot(const mjModel* model);

/// Those of "fingertips" that have no others further out, by side: what closes on an object.
struct LastSegments {
  std::vector<int> thumb, fingers;  ///< geoms
};
LastSegments LastSegmentsOf(const mjModel* model);

/// The site of this name ("tcp_tip", "tcp_power"), or the site "tcp" that stands for both; -1.
int ToolSite(const mjModel* model, std::string_view name);

/// Where what a drive moves stands, from the joints as they are: the engine's own lengths are those
/// of the last kinematics. Of tendons round sites and geoms these.
double DriveLength(const mjModel* model, const mjData* data, int actuator);
double DriveSpeed(const mjModel* model, const mjData* data, int actuator);

/// The joints of the hand, those that nothing drives among them.
std::vector<int> HandJoints(const mjModel* model);

/// The force of an actuator: gain * command + bias[0] + bias[1] * length + bias[2] *
/// speed, cut at its range.
struct AffineDrive {
  double gain = 1.0;
  double bias[3] = {0.0, 0.0, 0.0};
  double weakest = 0.0, strongest = 0.0;  ///< infinite where the file has no range
};
AffineDrive AffineOf(const mjModel* model, int actuator);

}  // namespace rangegrasp::mjcf
