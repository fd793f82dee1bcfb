#pragma once

#include "sim/execute.h"

namespace rangegrasp::sim::internal {

/// The drive of a hand: one motor.
struct HandDrive {
  /// First grip and strongest one. Less than 40 N lets a smooth bottle of 0.8 kg slip (8 mm at
  /// 20 N), more tilts a cup that is held by its rim (7 deg at 20 N, 14 at 40).
  double first_force_N = 40.0;
  double max_force_N = 100.0;
  double torque_per_force_Nm_N = 0.135;  ///< of the motor, for a newton between the tips
  double damping_Nm_s = 6.1;             ///< of the motor, per rad/s; 0: it has none
  double backlash_rad = 0.008;           ///< of the gear; infinite: it can be driven back
  /// A motor that turns slower stalls: 4 mm/s between the tips, where the free one makes 300.
  double stall_speed_rad_s = 0.03;
};

/// What the real hand feels.
struct HandReading {
  double angle_rad = 0.0;    ///< of the driven joints
  double speed_rad_s = 0.0;  ///< likewise
  double thumb_N = 0.0;      ///< pressure on the thumb's pad
  double fingers_N = 0.0;    ///< on the fingers' pads
  bool slips = false;        ///< a pad hears something slide
};

/// What the hand's motor does, from what the hand feels. Positive angles and torques close.
///
/// Closing runs at the speed limit, with a limited current, until both sides feel pressure (or the
/// motor stalls), then the force rises to the first grip; each slip felt after that adds to it, up
/// to the largest force. The force stays until the hand opens; the next closing begins with the
/// first grip again.
class GripControl {
 public:
  GripControl(const HandControlOptions& options, const HandDrive& drive, double timestep_s)
      : options_(options), drive_(drive), timestep_s_(timestep_s) {}

  /// Moves from an angle to another at the closing speed, and holds it.
  void Preshape(double from_rad, double to_rad);
  /// @param firm  the first grip is the strongest one
  void Close(bool firm = false);
  void Open();
  /// Once a time step. @return the motor's torque [Nm].
  double Tick(const HandReading& reading);

  enum class Mode { kPreshape, kClosing, kGripping, kOpening };
  Mode mode() const { return mode_; }
  bool Closing() const { return mode_ == Mode::kClosing; }
  bool Ratchets() const { return mode_ == Mode::kClosing || mode_ == Mode::kGripping; }
  bool Gripping() const;  ///< the first grip is reached
  double force_N() const { return force_N_; }
  /// What a moving hand may shove with [N].
  double moving_force_N() const;
  double commanded_rad() const { return commanded_rad_; }  ///< of the pre-shape, now
  int slips_heard() const { return slips_heard_; }         ///< each raised the force

 private:
  double MovingTorque(double speed_rad_s) const;
  double TickClosing(const HandReading& reading);
  double TickGripping(bool slips);
  bool Stalls(double speed_rad_s);

  HandControlOptions options_;
  HandDrive drive_;
  double timestep_s_;
  Mode mode_ = Mode::kPreshape;
  double target_rad_ = 0.0;
  double commanded_rad_ = 0.0;
  double force_N_ = 0.0;
  double first_force_N_ = 0.0;
  double stalled_s_ = 0.0;
  double gripping_s_ = 0.0;
  double since_slip_s_ = 0.0;
  int slips_heard_ = 0;
};

/// The lower limit of a joint whose gear is not back-drivable, from the one that it had and its
/// range's upper end: it follows the angle, less the gear's backlash (without that it would lock in
/// the blow of the closing fingers), and never falls.
double Ratchet(double lower_rad, double upper_rad, double angle_rad, double backlash_rad);

}  // namespace rangegrasp::sim::internal
