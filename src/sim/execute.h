#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/trajectory.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// The motions of one grasp and the hand's part in them.
struct GraspProgram {
  core::JointTrajectory reach, approach, lift, carry, lower, retreat;
  double opening_m = 0.1;  ///< gap of the pads before closing
};

/// The hand's controller: one motor, not back-drivable, slip-controlled grip. Forces are between
/// thumb and fingers. The prosthesis grips with 10 to 100 N and moves its tips at up to 300 mm/s,
/// 135 mm for each rad of its joints (maker's manual).
struct HandControlOptions {
  /// First grip. Less lets a smooth bottle of 0.8 kg slip (8 mm at 20 N), more tilts a cup that is
  /// held by its rim (7 deg at 20 N, 14 at 40).
  double initial_force_N = 40.0;
  double min_force_N = 10.0;
  double max_force_N = 100.0;
  double closing_speed_rad_s = 2.2;
  bool slip_control = true;
  double slip_gain_N = 10.0;  ///< added for each detection of slip: the forces' range in 6 steps
};

/// Bounds of the audit, in one place. Good holds of seven objects with this hand at 40 N met them
/// with room: creep up to 0.016 mm/s, penetration 0.1 to 0.4 mm, coupling 0.006 deg, energy 0.3 mJ.
struct AuditBounds {
  double penetration_p95_m = 0.001;
  double penetration_max_m = 0.002;
  double creep_m_s = 1e-4;         ///< of the held object relative to the palm while the hand rests
  double creep_rad_s = 0.0017453;  ///< 0.1 deg/s
  double equality_error_rad = 0.00087266;  ///< 0.05 deg, of the coupling of thumb and fingers
  /// Joint torque over its limit. An engine that cuts torques at the limit never exceeds 1.
  double torque_ratio = 1.0;
  double energy_gain_J = 0.005;
};

/// Which steps count. Torque: all. Penetration (the deepest of the hand's contacts with the target
/// in a step) and equality errors: from the closed hand to its release. Creep and energy: the rest
/// after the lift, when the servos have settled. The figures of a hold have bounds only if the
/// target was held after the lift; creep only if it was held to the end of the carry and no
/// fingertip slid during the rest: an object that slides out of the fingers obeys Coulomb's law, it
/// does not creep.
struct Audit {
  double penetration_p95_m = 0.0;
  double penetration_max_m = 0.0;
  double creep_m_s = 0.0;
  double creep_rad_s = 0.0;
  double equality_error_rad = 0.0;
  double torque_ratio = 0.0;
  double torque_limit_s = 0.0;  ///< time that a drive of the arm spent at its limit; has no bound
  /// Maximum rise of the held object's mechanical energy (kinetic and potential) during the rest,
  /// when no motor moves.
  double energy_gain_J = 0.0;
  int warnings = 0;    ///< of the engine; any is out of bounds
  std::string failed;  ///< the first figure out of bounds, with value and bound; empty if valid
};

/// What happened, as truth sees it.
struct ExecutionLog {
  double lift_height_m = 0.0;     ///< the target's rise at the end of the lift
  bool held_after_lift = false;   ///< touched by the hand alone
  bool held_after_carry = false;  ///< still so above the delivery place
  /// Horizontal, of the target's center of mass from the delivery place at the end.
  double final_distance_m = 0.0;
  bool at_rest = false;          ///< at the end
  bool touched_by_hand = false;  ///< at the end
  bool on_support = false;       ///< at the end it rests on the table, not on the floor
  /// Rotation and way of the object relative to the palm from closing to the end of the carry.
  double tilt_in_hand_rad = 0.0;
  double slip_in_hand_m = 0.0;
  double grip_force_N = 0.0;  ///< command at the end of the carry
  double simulated_s = 0.0;
  Audit audit;
};

/// Called at named moments ("start", "pregrasp", "closed", "lifted", "delivered", "end") and, if
/// frame_period_s > 0, at that period ("frame"). "delivered" is after lowering, before the hand
/// opens. A trial whose target is lost ends early: it has no later moments but "end".
struct ExecutionObserver {
  std::function<void(const std::string& moment, World& world)> on_moment;
  double frame_period_s = 0.0;
};

/// Runs a grasp program by servos and motor alone: no force but contact acts between hand and
/// object. The hand takes its pre-shape during the reach, closes, rests after the lift (for the
/// audit), carries, lowers, opens, and retreats; then the world steps until the target rests (3 s
/// at most). It ends early where the target is not held after the lift, or is lost on the way: the
/// outcome is decided. The arm should stand at the first sample of `reach`.
/// Everything depends on the world's state and the arguments alone.
/// @throws core::InputError if the scene lacks a tuple, body or site that it needs;
/// std::invalid_argument if `target` is not in the world.
ExecutionLog Execute(World& world, int target, const GraspProgram& program,
                     const HandControlOptions& hand, const AuditBounds& bounds,
                     const ExecutionObserver& observer = {});

}  // namespace rangegrasp::sim
