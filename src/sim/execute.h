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

/// The hand's controller: one motor, not back-drivable, slip-controlled grip.
struct HandControlOptions {
  double initial_force_N = 40.0;  ///< first grip, at the tips
  double min_force_N = 10.0;
  double max_force_N = 100.0;
  double closing_speed_rad_s = 2.2;
  bool slip_control = true;
  double slip_gain_N = 10.0;  ///< added for each detection of slip
};

/// Bounds of the audit, in one place (physics.md).
struct AuditBounds {
  double penetration_p95_m = 0.001;
  double penetration_max_m = 0.002;
  double creep_m_s = 1e-4;  ///< of the held object relative to the palm while the hand rests
  double creep_rad_s = 0.0017453;
  double equality_error_rad = 0.00087266;
  double torque_ratio = 1.0;  ///< joint torque over its limit
};
struct Audit {
  double penetration_p95_m = 0.0;
  double penetration_max_m = 0.0;
  double creep_m_s = 0.0;
  double creep_rad_s = 0.0;
  double equality_error_rad = 0.0;
  double torque_ratio = 0.0;
  double energy_gain_J = 0.0;  ///< mechanical energy gained beyond what motors and gravity did
  int warnings = 0;
  std::string
      failed;  ///< names the first figure out of bounds, with value and bound; empty if valid
};

/// What happened, as truth sees it.
struct ExecutionLog {
  double lift_height_m = 0.0;     ///< the target's rise at the end of the lift
  bool held_after_lift = false;   ///< touched by the hand alone
  bool held_after_carry = false;  ///< still so above the delivery place
  double final_distance_m =
      0.0;               ///< horizontal, target's centre of mass to the delivery place at the end
  bool at_rest = false;  ///< at the end
  bool touched_by_hand = false;  ///< at the end
  bool on_support = false;       ///< at the end it rests on the table, not on the floor
  double tilt_in_hand_rad =
      0.0;  ///< rotation of the object relative to the palm from closing to the end of the carry
  double slip_in_hand_m = 0.0;
  double grip_force_N = 0.0;  ///< command at the end of the carry
  double simulated_s = 0.0;
  Audit audit;
};

/// Called at named moments ("start", "pregrasp", "closed", "lifted", "delivered", "end") and, if
/// frame_period_s > 0, at that period ("frame").
struct ExecutionObserver {
  std::function<void(const std::string& moment, World& world)> on_moment;
  double frame_period_s = 0.0;
};

/// Runs a grasp program by servos and motor alone: no force but contact acts between hand and
/// object.
ExecutionLog Execute(World& world, int target, const GraspProgram& program,
                     const HandControlOptions& hand, const AuditBounds& bounds,
                     const ExecutionObserver& observer = {});

}  // namespace rangegrasp::sim
