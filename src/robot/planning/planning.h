#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/frames.h"
#include "base/rng.h"
#include "geometry/mesh.h"
#include "robot/timing.h"

namespace rangegrasp::planning {

/// What must not be hit: the work cell, the table's plane and the perceived objects, in W.
struct PlanningScene {
  double table_z_m = 0.0;
  std::vector<geometry::TriangleMesh> obstacles_W;  ///< perceived, completed surfaces; no target
  geometry::TriangleMesh target_W;                  ///< the one to be grasped
};

struct PickRequest {
  Eigen::VectorXd q_start;
  base::Pose X_WH = base::Pose::Identity();  ///< hand at the grasp
  Eigen::Vector3d approach_W = -Eigen::Vector3d::UnitZ();
  double opening_m = 0.1;     ///< gap between the pads during the approach
  double closed_gap_m = 0.0;  ///< gap when the object is held
  /// The object (not hand and arm) may push what it touches during the lift, if it is clear
  /// afterwards: neighbors yield, and the completed surface is a guess.
  bool may_brush = false;
};

struct PlanOptions {
  double approach_m = 0.2;  ///< start of the approach above the grasp, along its axis (section 4.3)
  double lift_m = 0.2;
  /// The object is released this far above the height it stood at. The sensor's calibration may be
  /// off (three times 0.1 deg and 1 mm at 1 m are 6 mm), and a hand that presses into the table
  /// moves the arm.
  double lower_clearance_m = 0.010;
  /// An object seen down to less than this above the table stands on it: its lowest points were
  /// assigned to the table, or lost to grazing light.
  double standing_m = 0.03;
  double retreat_m = 0.15;  ///< back along the approach axis after release
  double contact_m = 0.06;  ///< the last part of the approach, where the hand may touch the target
  /// Growth of the arm and the hand. The hand moves without it where the grasp was checked more
  /// closely: in the approach, the lift, the lowering and the retreat.
  double collision_margin_m = 0.003;
  /// Margin of the hand and the held object to the work cell, in the carry. The calibration's error
  /// is up to 6 mm (lower_clearance_m), and a joint may lag by 5 mrad, 4 mm at the hand.
  double cell_margin_m = 0.010;
  double resolution_rad = 0.04;  ///< of path validity checks (2-norm of the joint step)
  int ik_solutions = 6;          ///< number of branches tried whose approach is free, best first
  int ik_per_branch = 8;         ///< solutions drawn for each of them: most are blocked
  /// Cost of a solution for each joint right at a limit; it falls to 0 over the zone. A joint with
  /// room to move on is worth a second of travel.
  double limit_cost_s = 1.0;
  double limit_zone_rad = 0.35;  ///< 20 deg
  /// Share of approach and lift if the full length is blocked: the arm may lack room high up.
  double shortened = 0.6;
  int planning_iterations = 1500;    ///< of RRTConnect, for one query
  double planning_s = 2.0;           ///< bound for one OMPL query, a backstop to the iterations
  double carry_tilt_rad = 0.44;      ///< the object leans no further in transit (25 deg)
  int carry_yaws = 12;               ///< turns about the vertical tried for the delivery
  int carry_goals = 3;               ///< goals of the carry in joint space, if the arc is blocked
  double step_m = 0.01;              ///< between poses of straight lines and arcs
  robot::TimingOptions free_motion;  ///< published limits
  /// With the object in the hand: slower, because tall and heavy ones tip and slip otherwise (an
  /// acceleration of half the limits is below 0.1 g at the hand).
  robot::TimingOptions held_motion{.velocity_scale = 0.7, .acceleration_scale = 0.5};
};

/// A whole pick and place, all collision-checked against perceived geometry.
struct PickPlan {
  base::JointTrajectory reach;     ///< start to the pose approach_m above the grasp
  base::JointTrajectory approach;  ///< straight
  base::JointTrajectory lift;      ///< straight, vertical
  base::JointTrajectory carry;     ///< to above the delivery place
  base::JointTrajectory lower;     ///< straight, vertical
  base::JointTrajectory retreat;   ///< straight back along the approach axis after release
};

enum class PlanFailure {
  kNone,
  kNoIk,             ///< no arm configuration reaches the grasp
  kApproachBlocked,  ///< the approach is blocked in each configuration
  kNoReach,          ///< no path from q_start to the start of an approach was found
  kNoCarry           ///< no path from the lifted grasp to the delivery place
};
constexpr std::array<std::string_view, 5> WordsOf(PlanFailure) {
  return {"none", "no_ik", "approach_blocked", "no_reach", "no_carry"};
}

struct PlanResult {
  std::optional<PickPlan> plan;
  PlanFailure failure = PlanFailure::kNone;
  /// What was in the way, by the names of the MJCF ("arm/link6 and the hand"): the most frequent in
  /// blocked approaches, or the contact at a start that cannot be left; may be empty.
  std::string blocked_by;
};

/// Plans with OMPL (RRTConnect in joint space, then shortcuts) and FCL. Inverse kinematics at the
/// grasp gives branches, those near to q_start and far from the limits first. Each is followed
/// through approach, lift, carry, lowering and retreat as motions of the hand on lines; the carry
/// follows an arc about the arm's base and turns only about the vertical. The first branch that is
/// free all the way, and that RRTConnect reaches from q_start, wins. If the arc is blocked for all
/// branches, RRTConnect plans the carry with bounded tilt.
///
/// The object moves with the hand from the lift to the lowering and is released with its lowest
/// point lower_clearance_m above the table, or as low as the hand allows. Objects that it touches
/// at the grasp are no obstacles to its lift until they have separated.
///
/// The same scene and arguments give the same plan (unless the backstop planning_s strikes). Not
/// thread-safe.
class Planner {
 public:
  Planner(const robot::Robot& robot, PlanOptions options);
  ~Planner();
  /// Sets the scene that all later plans have to keep clear of; it is empty at first.
  void SetScene(PlanningScene scene);
  PlanResult Plan(const PickRequest& request, base::Rng& rng);
  /// Whether the arm with an empty, open hand may be there: within limits, clear of everything.
  bool IsFree(const Eigen::VectorXd& q) const;
  /// Plans a motion between two free positions; nullopt if none was found.
  std::optional<base::JointTrajectory> PlanMotion(const Eigen::VectorXd& q_start,
                                                  const Eigen::VectorXd& q_goal, base::Rng& rng);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rangegrasp::planning
