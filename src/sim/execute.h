#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
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
  kTruth,     ///< the target is lost: the outcome of a single trial is decided
  kAperture,  ///< the hand has closed on nothing, by its own joints: what a real hand knows
};
/// A person who takes what the hand has carried, and draws until it lets go or patience ends.
struct UserOptions {
  Eigen::Vector3d direction_H{0.0, 0.0, 1.0};  ///< unit; in the hand's root frame
  double wait_s = 1.0;      ///< meanwhile nothing pulls, and the hand has to hold
  double force_N = 15.0;    ///< what it rises to
  double rise_s = 0.5;      ///< in this time
  double patience_s = 2.0;  ///< of drawing in vain
  double draw_m = 0.15;     ///< so far once the hand has let go
};
/// The motions of one grasp and the hand's part in them.
struct GraspProgram {
  base::JointTrajectory reach, approach, lift, carry, lower, retreat;
  /// Takes the object above the delivery place; without it the hand lowers it there.
  std::optional<UserOptions> user;
  double opening_m = 0.1;  ///< gap of the pads before closing
  bool firm = false;       ///< begins with the strongest grip
  EndsBy ends_by = EndsBy::kTruth;
  /// Where a fingertip meets something with more than this left of the approach, the hand goes back
  /// up: what stands there was not planned for. Infinite: it closes where it is.
  double withdraw_m = std::numeric_limits<double>::infinity();
};

/// The hand's controller. Forces are between thumb and fingers. The prosthesis grips with 10 to
/// 100 N and moves its tips at up to 300 mm/s, 135 mm for each rad of its joints (maker's manual).
struct HandControlOptions {
  /// First grip and strongest one; without them the numeric "grip_force" of the hand's model.
  std::optional<double> initial_force_N, max_force_N;
  double min_force_N = 10.0;
  double closing_speed_rad_s = 2.2;
  bool slip_control = true;
  double slip_gain_N = 10.0;  ///< added for each slip that is heard: the forces' range in 6 steps
  // What the sensors in the distal pads hear of a slip. The maker states none of it: estimates.
  double slip_threshold_m_s = 0.002;  ///< slower sliding is not heard: twice where sliding begins
  double slip_delay_s = 0.02;         ///< from the slide to the controller
  double slip_noise_m_s = 0.0004;     ///< standard deviation of a reading: a fifth of the threshold
};

/// Bounds of the audit, by what a figure would mean in the world, so that they hold for objects,
/// hands and time steps that nobody has tried.
struct AuditBounds {
  /// A glove of PVC gives by 1 to 2 mm: in 95 % of the steps by the lower, at most by the higher.
  double penetration_p95_m = 0.001;
  double penetration_max_m = 0.002;
  /// Of the thickness of what is held: in a thin thing, such as a cup's wall, less is too deep.
  double penetration_share = 0.25;
  /// Of all contacts but the grip: what the held object, the hand and their neighbors stand on,
  /// lean on or push. In 95 % of the steps by the lower; a fall from a lift's height of 0.2 m ends
  /// at 2 m/s, 3.6 mm deep in contacts that give way within 5 ms.
  double elsewhere_p95_m = 0.001;
  double elsewhere_max_m = 0.004;
  /// Of a contact's point on the held object while the hand rests: a tenth of the speed that counts
  /// as sliding. And of the object's turning in the hand: 0.1 deg/s, by which a point 60 mm from
  /// the contact moves as fast. Delivered single objects creep by a ninth at most.
  double creep_m_s = 1e-4;
  double creep_rad_s = 0.1 * base::kDeg;
  /// Until the held object rests in the lifted hand: slip control hears eight slips and raises the
  /// force from 20 to 100 N in 0.5 s. What slides for longer, and stays in the hand, creeps.
  double unrest_s = 1.5;
  /// Of joints that are coupled, as a share of their range, of points that are joined, of 0.1 m:
  /// 0.14 deg of 48, or 0.3 mm between the tips. Single objects reach 0.03 deg, a pinched wall of
  /// 4 mm 0.06; a jaw that drives two slides 0.0006 of theirs.
  double equality_share = 0.003;
  /// What the pads of the side pressed less feel, as a multiple of the strongest grip: a wedge, a
  /// cam or a dead point may hold some more than the motor gives, a real hand's gear would break.
  double grip_share = 3.0;
  /// Rise of the held object that its energy would pay for, while no motor moves: 0.3 mJ for 0.3
  /// kg.
  double energy_gain_m = 0.0001;
  /// Time that drives of the arm may spend at their limits, where trials reach 0.03 s.
  double drive_limit_s = 0.2;
  /// Of a joint behind its command where nothing may be in the way; a tool at 1 m is then 10 mm
  /// off, more than any clearance of the plans.
  double tracking_error_rad = 0.01;
};

/// Which steps count. Solver, drives, tracking and penetration elsewhere: all. Penetration (the
/// deepest of the hand's contacts with the target in a step) and equality errors: from the closed
/// hand to its release. Creep and energy: 0.4 s after the lift, when the servos have settled, that
/// begin anew where a fingertip slides or the grip changes: the hand then works, or the object
/// obeys Coulomb's law. Warnings and unsolved steps are out of bounds in every trial. The other
/// bounds are those of a success: they count only if the target was held after the lift, creep and
/// unrest only if it was held to the end of the carry; a trial without is a failure by itself.
struct Audit {
  double penetration_p95_m = 0.0, penetration_max_m = 0.0;
  double penetration_share = 0.0;  ///< of the thickness between the contacts that hold
  double elsewhere_p95_m = 0.0, elsewhere_max_m = 0.0;  ///< penetration
  double unrest_s = 0.0;                                ///< before the rest
  double creep_m_s = 0.0;
  double creep_rad_s = 0.0;  ///< of the held object, relative to the palm
  double equality_share = 0.0;
  double grip_share = 0.0;  ///< at the ends of lift and carry
  double drive_limit_s = 0.0, tracking_error_rad = 0.0, energy_gain_J = 0.0;
  int warnings = 0;        ///< of the engine; any is out of bounds
  int repeated_steps = 0;  ///< which the solver had to solve again with dense matrices
  int unsolved_steps = 0;  ///< of these, which it did not solve then; any is out of bounds
  std::string failed;      ///< the first figure out of bounds, with value and bound; empty if valid
};

/// What the hand's joints show of what it holds, without truth.
struct ApertureLog {
  double lifted_rad = 0.0;   ///< from the closed end, when the lift has ended
  double carried_rad = 0.0;  ///< above the delivery place; 0 where it was not carried
  bool holds_after_lift = false, holds_after_carry = false;
};

/// What came of handing over.
struct HandOverLog {
  bool early = false;   ///< the arm felt a pull before there was one
  bool felt = false;    ///< the arm felt the pull, and the hand opened
  double felt_N = 0.0;  ///< the pull at that moment
  double felt_s = 0.0;  ///< since it began
  bool taken = false;   ///< at the end the person has it, clear of the hand
};

/// What happened, as truth sees it. What describes a hold is of the moment when the hold ended.
struct ExecutionLog {
  int target = 0;                 ///< the object that all this is of
  double lift_height_m = 0.0;     ///< the target's rise at the end of the lift
  bool held_after_lift = false;   ///< the lift came to its end; touched by the hand alone
  bool held_after_carry = false;  ///< still so above the delivery place
  /// Horizontal, of the target's center of mass from the delivery place at the end.
  double final_distance_m = 0.0;
  bool at_rest = false, touched_by_hand = false;  ///< at the end
  bool on_support = false;  ///< at the end it rests on the table, not on the floor
  /// Rotation and way of the object relative to the palm since the hand closed.
  double tilt_in_hand_rad = 0.0, slip_in_hand_m = 0.0;
  /// The most that it leaned from when the hand closed until the hand let go, the carry included.
  double lean_rad = 0.0;
  double grip_force_N = 0.0;  ///< command
  double felt_force_N = 0.0;  ///< on the pads of the side that is pressed less
  int slips_heard = 0;        ///< each raised the force
  double lift_lag_rad = 0.0;  ///< largest, of a joint: what lay about the object was pushed
  /// Largest of each joint behind its command where nothing is in the way: reach, carry, retreat,
  /// and the approach until the hand touches the target.
  Eigen::VectorXd lags_rad;
  double tracking_error_m = 0.0;  ///< of the hand before it closed, from where it was sent
  /// Motions that ended early since the drives felt something in the way: "approach" and "lower",
  /// which may touch, and "reach", "lift" (stuck), "carry", "retreat", which end the grasp.
  std::vector<std::string> stopped_by_contact;
  std::vector<Eigen::Vector3d> met_W;  ///< where fingertips pressed when the hand withdrew
  /// Joints of the arm that came within half a degree (5 mm, of slides) of their range's ends, or
  /// whose drives spent time at their limits.
  std::vector<std::string> joints_at_limits;
  double simulated_s = 0.0;
  ApertureLog aperture;                  ///< all that is no truth
  std::optional<HandOverLog> hand_over;  ///< where a user was to take the object, and it came there
  Audit audit;
};

/// What a viewer may see of an execution at a moment.
struct ExecutionState {
  /// "reach", "approach", "close", "lift", "carry", "deliver", "hand over", "end"
  std::string stage;
  double time_s = 0.0;   ///< of the world
  int target = 0;        ///< the object that it is of
  double force_N = 0.0;  ///< command of the grip
  double felt_N = 0.0;   ///< on the pads of the side that is pressed less
  double slip_m = 0.0;   ///< way of the object in the hand since this has closed; 0 before
};

/// Called at named moments ("pregrasp", "closed", "lifted", "delivered": lowered, but still closed,
/// "end") and, if frame_period_s > 0, at that period ("frame"). A trial whose target is lost has no
/// later moments but "end".
struct ExecutionObserver {
  std::function<void(const std::string& moment, World& world)> on_moment;
  /// Called before each on_moment.
  std::function<void(const ExecutionState& state)> on_state = {};
  double frame_period_s = 0.0;
};

/// What came of a motion of the arm that nothing should be in the way of.
struct MoveLog {
  bool arrived = false;      ///< if not, the drives felt something, and the arm stands where it was
  double lag_rad = 0.0;      ///< largest, of a joint behind its command
  double simulated_s = 0.0;  ///< with the rest at the end
};

/// Sends the arm along a trajectory from where it stands by its servos alone, the hand without
/// force, and waits until it rests. Ends where a joint falls behind as if something is in the way.
/// @throws base::InputError if the scene has no arm
MoveLog MoveArm(World& world, const base::JointTrajectory& trajectory);

/// Runs a grasp program by servos and motor alone: no force but contact acts between hand and
/// object. The hand takes its pre-shape during the reach, closes, rests after the lift (for the
/// audit), carries, lowers, opens, and retreats; then the world steps until the target rests (3 s
/// at most). Approach and lowering end where the drives feel something in the way (the approach
/// goes back where fingertips met it early, and nothing else follows), the lift pushes neighbors
/// until it is stuck, and the arm gives way to a hand that closes against something. It ends early
/// where the target is not held after the lift, or is lost on the way, or another motion meets
/// something. A program that ends by the aperture is about what the hand presses hardest when it
/// has closed (the given target if nothing), goes on until the hand's joints tell that it holds
/// nothing, and leaves the hand open. The arm should stand at the first sample of `reach`.
/// Everything depends on the world's state and the arguments alone.
/// @param rng  of the slip sensors' noise
/// @throws base::InputError if the scene lacks a tuple, body or site that it needs;
/// std::invalid_argument if `target` is not in the world.
ExecutionLog Execute(World& world, int target, const GraspProgram& program,
                     const HandControlOptions& hand, const AuditBounds& bounds, base::Rng rng,
                     const ExecutionObserver& observer = {});

}  // namespace rangegrasp::sim
