#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/frames.h"
#include "base/rng.h"
#include "base/units.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// What ends a grasp early.
enum class EndsBy {
  kTruth,     ///< the target is lost in the simulation, which decides a single trial
  kAperture,  ///< the hand's joints show that it closed on nothing, as a real hand can measure
};
/// A person who takes the carried object and pulls until the hand lets go or their patience ends.
struct UserOptions {
  Eigen::Vector3d direction_H{0.0, 0.0, 1.0};  ///< unit; in the hand's root frame
  double wait_s = 1.0;      ///< time before the pull; the hand has to hold the object meanwhile
  double force_N = 15.0;    ///< final pulling force
  double rise_s = 0.5;      ///< rise time of the force
  double patience_s = 2.0;  ///< time of pulling at full force before giving up
  double draw_m = 0.15;     ///< pulling distance once the hand has let go
};
/// The motions of one grasp and the settings of the hand.
struct GraspProgram {
  base::JointTrajectory reach, approach, lift, carry, lower, retreat;
  /// Takes the object above the delivery place; if absent, the hand lowers it there.
  std::optional<UserOptions> user;
  double opening_m = 0.1;  ///< gap between the pads before closing
  bool firm = false;       ///< starts with the maximum grip force
  EndsBy ends_by = EndsBy::kTruth;
};

/// Options of the hand's control. Forces act between thumb and fingers. The prosthesis grips with
/// 10 to 100 N; its tips move at up to 300 mm/s, 135 mm per rad of its joints (maker's manual).
struct HandControlOptions {
  /// Initial and maximum force; if absent, the numeric "grip_force" of the hand's model.
  std::optional<double> initial_force_N, max_force_N;
  double min_force_N = 10.0;  ///< of a moving hand, unless the first grip is weaker
  double closing_speed_rad_s = 2.2;
  bool slip_control = true;
  double slip_gain_N = 10.0;  ///< force added per detected slip
  // Slip detection by the sensors in the distal pads. Estimates: the maker publishes no values.
  double slip_threshold_m_s = 0.002;  ///< slowest slip detected; twice the speed where slip begins
  double slip_delay_s = 0.02;         ///< from the slip to the controller
  double slip_noise_m_s = 0.0004;     ///< standard deviation of a reading: a fifth of the threshold
};

/// Bounds of the audit. Each follows from the physical meaning of its figure, so that it also holds
/// for objects, hands and time steps that have not been tried.
struct AuditBounds {
  /// A PVC glove yields by 1 to 2 mm. The lower value bounds 95 % of the steps, the higher one all.
  double penetration_p95_m = 0.001;
  double penetration_max_m = 0.002;
  /// Share of the held part's thickness: a thin part, such as a cup's wall, allows less depth.
  double penetration_share = 0.25;
  /// Penetration of all contacts except the grip: where the held object, the hand or their
  /// neighbors stand, lean or push. The lower value bounds 95 % of the steps. A fall from the
  /// lift's height of 0.2 m ends at 2 m/s, 3.6 mm deep in contacts that yield within 5 ms.
  double elsewhere_p95_m = 0.001;
  double elsewhere_max_m = 0.004;
  /// Speed of a contact's point on the held object while the hand rests: a tenth of the speed that
  /// counts as sliding. Rotation of the object in the hand: 0.1 deg/s, which moves a point 60 mm
  /// from the contact as fast. Delivered single objects creep by at most a ninth of this.
  double creep_m_s = 1e-4;
  double creep_rad_s = 0.1 * base::kDeg;
  /// Time until the held object rests in the lifted hand. Slip control takes eight slips and 0.5 s
  /// to go from 20 to 100 N. An object that slides longer but stays in the hand creeps.
  double unrest_s = 1.5;
  /// Equality errors: of coupled joints as a share of their range, of connected points as a share
  /// of 0.1 m. This is 0.14 deg of 48 deg, or 0.3 mm between the tips. Single objects reach 0.03
  /// deg, a pinched 4 mm wall 0.06 deg; a jaw that drives two slides 0.0006 of their range.
  double equality_share = 0.003;
  /// Force on the pads of the less loaded side, as a multiple of the maximum grip force. A wedge, a
  /// cam or a dead point may hold somewhat more than the motor gives; more would break a real gear.
  double grip_share = 3.0;
  /// Energy gained by the held object while no motor moves, as the height that it corresponds to:
  /// 0.3 mJ for 0.3 kg.
  double energy_gain_m = 0.0001;
  /// Time that drives of the arm may spend at their limits. Trials reach 0.03 s.
  double drive_limit_s = 0.2;
  /// Lag of a joint behind its command in free motion. It displaces a tool at 1 m by 10 mm, more
  /// than any clearance of the plans.
  double tracking_error_rad = 0.01;
};

/// Solver, drives, tracking and penetration elsewhere are measured in all steps. Penetration (of
/// the hand's deepest contact with the target in a step) and equality errors are measured from the
/// closing of the hand to its release. Creep and energy are measured for 0.4 s after the lift, when
/// the servos have settled. This time restarts when a fingertip slides or the grip changes: then
/// the hand does work, or the object obeys Coulomb's law. Warnings and unsolved steps are out of
/// bounds in every trial. The other bounds apply only if the target was held after the lift, creep
/// and unrest only if it was held to the end of the carry; otherwise the trial is a failure anyway.
struct Audit {
  double penetration_p95_m = 0.0, penetration_max_m = 0.0;
  double penetration_share = 0.0;  ///< share of the thickness between the holding contacts
  double elsewhere_p95_m = 0.0, elsewhere_max_m = 0.0;  ///< penetration
  double unrest_s = 0.0;                                ///< time before the rest
  double creep_m_s = 0.0;
  double creep_rad_s = 0.0;  ///< rotation of the held object relative to the palm
  double equality_share = 0.0;
  double grip_share = 0.0;  ///< at the end of the lift and of the carry
  double drive_limit_s = 0.0, tracking_error_rad = 0.0, energy_gain_J = 0.0;
  int warnings = 0;        ///< engine warnings; any is out of bounds
  int repeated_steps = 0;  ///< steps that were solved again with dense matrices
  int unsolved_steps = 0;  ///< steps that were not even solved then; any is out of bounds
  std::string failed;      ///< the first figure out of bounds, with value and bound; empty if valid
};

/// What the hand's joints show about the held object, without ground truth.
struct ApertureLog {
  double lifted_rad = 0.0;   ///< angle from the closed end at the end of the lift
  double carried_rad = 0.0;  ///< the same above the delivery place; 0 if not carried
  bool feels_object_after_lift = false, feels_object_after_carry = false;
};

/// Result of a handover.
struct HandOverLog {
  bool early = false;   ///< the arm felt a pull before there was one
  bool felt = false;    ///< the arm felt the pull, and the hand opened
  double felt_N = 0.0;  ///< the pull at that moment
  double felt_s = 0.0;  ///< time from the start of the pull to that moment
  bool taken = false;   ///< at the end the person has the object, clear of the hand
};

/// Ground truth of an execution. Values about a hold are those at the moment when the hold ended.
struct ExecutionLog {
  int target = 0;                 ///< the object that the log is about
  double lift_height_m = 0.0;     ///< the target's rise at the end of the lift
  bool held_after_lift = false;   ///< the lift was completed; only the hand touches the target
  bool held_after_carry = false;  ///< the same above the delivery place
  /// Horizontal distance of the target's center of mass from the delivery place at the end.
  double final_distance_m = 0.0;
  bool at_rest = false, touched_by_hand = false;  ///< at the end
  bool on_support = false;  ///< at the end it rests on the table, not on the floor
  /// Rotation and displacement of the object relative to the palm since the hand closed.
  double tilt_in_hand_rad = 0.0, slip_in_hand_m = 0.0;
  /// Largest tilt against the pose at closing until the hand let go, including the carry.
  double lean_rad = 0.0;
  double grip_force_N = 0.0;  ///< commanded
  double felt_force_N = 0.0;  ///< on the pads of the less loaded side
  int slips_heard = 0;        ///< detected slips; each raised the force
  double lift_lag_rad = 0.0;  ///< largest lag of a joint, from pushing the object's neighbors
  /// Largest lag of each joint behind its command in free motion: reach, carry, retreat, and the
  /// approach until the hand touches the target.
  Eigen::VectorXd lags_rad;
  double tracking_error_m = 0.0;  ///< distance of the hand from its commanded place before closing
  /// Motions that ended early because the drives felt an obstacle: "approach" and "lower", which
  /// may touch, and "reach", "lift" (stuck), "carry", "retreat", which end the grasp.
  std::vector<std::string> stopped_by_contact;
  /// Joints of the arm that came within 0.5 deg (slides: 5 mm) of an end of their range, or whose
  /// drives spent time at their limits.
  std::vector<std::string> joints_at_limits;
  double simulated_s = 0.0;
  ApertureLog aperture;                  ///< without ground truth
  std::optional<HandOverLog> hand_over;  ///< present if the object came to where a user takes it
  Audit audit;
};

/// State of an execution at one moment, for viewers.
struct ExecutionState {
  /// "reach", "approach", "close", "lift", "carry", "deliver", "hand over", "end"
  std::string stage;
  double time_s = 0.0;   ///< of the world
  int target = 0;        ///< the target object
  double force_N = 0.0;  ///< commanded grip force
  double felt_N = 0.0;   ///< on the pads of the less loaded side
  double slip_m = 0.0;   ///< displacement of the object in the hand since closing; 0 before
};

/// Called at named moments ("pregrasp", "closed", "lifted", "delivered": lowered, but still closed,
/// "waits", "pulled", "taken" of a handover, "end") and, if frame_period_s > 0, at that period
/// ("frame"). After the loss of its target there is only "end".
struct ExecutionObserver {
  std::function<void(const std::string& moment, World& world)> on_moment;
  /// Called before each on_moment.
  std::function<void(const ExecutionState& state)> on_state = {};
  double frame_period_s = 0.0;
};

/// Result of a free motion of the arm.
struct MoveLog {
  bool arrived = false;      ///< if not, the drives felt an obstacle and the arm stopped there
  double lag_rad = 0.0;      ///< largest lag of a joint behind its command
  double simulated_s = 0.0;  ///< including the rest at the end
};

/// Moves the arm along a trajectory from its present position by its servos alone, with no force of
/// the hand, and waits until it rests. Stops early if a joint lags as if it had met an obstacle.
/// @throws base::InputError if the scene has no arm
MoveLog MoveArm(World& world, const base::JointTrajectory& trajectory);

/// Runs a grasp program by servos and motor alone: only contact forces act between hand and object.
/// The hand takes its pre-shape during the reach, closes, rests after the lift (for the audit),
/// carries, lowers, opens, and retreats. Then the world steps until the target rests, for at most 3
/// s. Approach and lowering stop when the drives feel an obstacle; the hand then closes or opens
/// where it is. The lift pushes neighbors until it is stuck, and the arm yields to a hand that
/// closes against something. The program ends early if the target is not held after the lift or is
/// lost on the way, or if another motion meets an obstacle. With EndsBy::kAperture, the target
/// becomes the object that the closed hand presses hardest (the given one if there is none), and
/// the program goes on until the hand's joints show that it holds nothing; the hand ends open. The
/// arm should be at the first sample of `reach`. The result depends only on the world's state and
/// the arguments.
/// @param rng  for the slip sensors' noise
/// @throws base::InputError if the scene lacks a tuple, body or site that it needs;
/// std::invalid_argument if `target` is not in the world.
ExecutionLog Execute(World& world, int target, const GraspProgram& program,
                     const HandControlOptions& hand, const AuditBounds& bounds, base::Rng rng,
                     const ExecutionObserver& observer = {});

}  // namespace rangegrasp::sim
