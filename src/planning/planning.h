#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/rng.h"
#include "core/trajectory.h"
#include "geometry/mesh.h"
#include "robot/robot.h"

namespace rangegrasp::planning {

/// What must not be hit: the work cell, the table's plane and the perceived objects, in W.
struct PlanningScene {
  double table_z_m = 0.0;
  std::vector<geometry::TriangleMesh>
      obstacles_W;  ///< perceived, completed surfaces, without the one to be grasped
  geometry::TriangleMesh target_W;  ///< the one to be grasped
};

struct PickRequest {
  Eigen::VectorXd q_start;
  core::Pose X_WH = core::Pose::Identity();  ///< hand at the grasp
  Eigen::Vector3d approach_W = -Eigen::Vector3d::UnitZ();
  double opening_m = 0.1;     ///< gap of the pads during the approach
  double closed_gap_m = 0.0;  ///< gap when the object is held
};

struct PlanOptions {
  double approach_m = 0.2;  ///< the start above the grasp along the approach axis (section 4.3)
  double lift_m = 0.2;
  double lower_clearance_m = 0.004;  ///< the object is let go this far above the height it stood at
  double planning_s = 2.0;  ///< bound for one OMPL query; solves are normally a hundredth of it
  int ik_solutions = 6;     ///< tried for each pose
  double collision_margin_m = 0.003;
  double resolution_rad = 0.04;      ///< of path validity checks
  robot::TimingOptions free_motion;  ///< published limits
  robot::TimingOptions held_motion;  ///< with the object in the hand
};

/// A whole pick and place, all collision-checked against perceived geometry.
struct PickPlan {
  core::JointTrajectory reach;     ///< start to the pose approach_m above the grasp
  core::JointTrajectory approach;  ///< straight
  core::JointTrajectory lift;      ///< straight, vertical
  core::JointTrajectory carry;     ///< to above the delivery place
  core::JointTrajectory lower;     ///< straight, vertical
  core::JointTrajectory retreat;   ///< straight up after release
};

enum class PlanFailure { kNone, kNoIk, kApproachBlocked, kNoReach, kNoCarry };
const char* Name(PlanFailure failure);

struct PlanResult {
  std::optional<PickPlan> plan;
  PlanFailure failure = PlanFailure::kNone;
  double ik_s = 0.0, path_s = 0.0;  ///< wall seconds
};

/// Plans with OMPL (RRTConnect in joint space, shortcut) and FCL. The object rides with the hand
/// during carry. OMPL's random generator is global to the process: seeded from rng, one planner at
/// a time. The number of iterations, not the clock, decides where it can, so that the same seed
/// gives the same plan.
class Planner {
 public:
  Planner(const robot::Robot& robot, PlanOptions options);
  ~Planner();
  PlanResult Plan(const PlanningScene& scene, const PickRequest& request, core::Rng& rng);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rangegrasp::planning
