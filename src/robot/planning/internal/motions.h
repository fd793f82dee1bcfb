#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/rng.h"
#include "robot/collision/collider.h"
#include "robot/planning/planning.h"
#include "robot/robot.h"

namespace rangegrasp::planning::internal {

using JointPath = std::vector<Eigen::VectorXd>;

/// A path search in joint space.
struct JointQuery {
  Eigen::VectorXd start, goal;
  std::function<bool(const Eigen::VectorXd&)> free;
  /// Moves a uniform sample to a region worth searching; may be empty.
  std::function<void(Eigen::VectorXd&)> project;
  double resolution_rad = 0.04;
  int iterations = 1500;
  double seconds = 2.0;  ///< wall time
};

/// Waypoints from start to goal: the straight line if it is free, else RRTConnect (Kuffner and
/// LaValle 2000, from OMPL) with shortcuts. nullopt if none was found.
std::optional<JointPath> PlanJointPath(const robot::Robot& robot, const JointQuery& query,
                                       base::Rng& rng);

/// What a stage of the motion may touch, and how far its hand may tilt.
struct Stage {
  collision::Contacts contacts;
  double min_upright = -1.0;  ///< the cosine of the hand's largest tilt away from up_H
  Eigen::Vector3d up_H = Eigen::Vector3d::UnitZ();
};

/// Whether `free` holds along the joint line, in steps of resolution_rad, except at its start.
bool EdgeFree(const std::function<bool(const Eigen::VectorXd&)>& free, const Eigen::VectorXd& from,
              const Eigen::VectorXd& to, double resolution_rad);

/// Checks joint limits, tilt and collisions along joint paths.
class MotionCheck {
 public:
  MotionCheck(const robot::Robot& robot, double margin_m, double cell_margin_m = 0.0)
      : robot_(robot), collider_(robot, margin_m, cell_margin_m) {}

  collision::RobotCollider& collider() { return collider_; }

  /// Whether q is within the limits, upright enough and touches nothing that the stage forbids.
  bool Free(const Eigen::VectorXd& q, const Stage& stage);
  /// Why q is not free: what touches what, or which limit it exceeds; empty if it is free.
  std::string WhyNot(const Eigen::VectorXd& q, const Stage& stage);
  /// The same for the joint lines between the path's points, at steps of resolution_rad.
  bool PathFree(const JointPath& path, const Stage& stage, double resolution_rad);

 private:
  const robot::Robot& robot_;
  collision::RobotCollider collider_;
};

/// Data of one request for all branches of the inverse kinematics.
struct Task {
  base::Pose X_WH;
  Eigen::Vector3d approach_W;
  Eigen::Vector3d center_W;     ///< of the object at its initial place
  Eigen::Vector3d delivered_W;  ///< the same point at the release
  Eigen::Vector3d base_W;       ///< of the arm; carries turn about it
  double approach_m = 0.0, lift_m = 0.0;
  double below_m = 0.0;  ///< how far a standing object reaches below its perceived part
  std::size_t open_state = 0, closed_state = 0;  ///< of HandModel::states
  bool may_brush = false;                        ///< see PickRequest
};

/// Computes where everything goes: the object's middle, and how low it may be released.
Task MakeTask(const robot::Robot& robot, const PlanningScene& scene, const PickRequest& request,
              const PlanOptions& options, const collision::RobotCollider& collider);

/// The rotations about the vertical [rad] for a delivery, those with the least turning of the wrist
/// first: the object's rotation about the base, plus k * 2 pi / count.
std::vector<double> DeliveryYaws(const Task& task, int count);

/// The hand's pose between grasp and delivery: at share t of the way around the base, dz above the
/// height of the grasp.
base::Pose CarryPose(const Task& task, double yaw_rad, double t, double dz_m);

/// The hand's motions with one arm configuration at the grasp.
struct Branch {
  Eigen::VectorXd q_grasp;
  JointPath approach, lift, carry, lower, retreat;
};

/// Builds and checks the motions of a branch, one after the other.
class BranchBuilder {
 public:
  BranchBuilder(const robot::Robot& robot, const PlanOptions& options, MotionCheck& check,
                const Task& task)
      : robot_(robot), options_(options), check_(check), task_(task) {}

  /// From approach_m above the grasp straight down to it.
  /// @param why  set if it is not free: what touches what
  bool Approach(Branch& branch, std::string& why) const;
  bool Lift(Branch& branch) const;
  /// On an arc around the base at the lifted height, then down and away: the first yaw that works.
  bool CarryOnArc(Branch& branch) const;
  /// Lowering and retreat from branch.carry.back().
  bool LowerAndRetreat(double yaw_rad, Branch& branch) const;

  /// For the open hand, before the grasp and away from it.
  Stage ReachStage() const;
  /// For the held object; nothing that was perceived may be touched. Keeps the margin to the work
  /// cell unless the object stood closer to it, and is therefore closer at the end of the lift.
  Stage CarryStage(const Eigen::VectorXd& q_lift) const;

 private:
  Stage HeldStage() const;  ///< the same, but the table may be touched
  std::vector<base::Pose> ArcPoses(double yaw_rad, const base::Pose& X_WLifted) const;

  const robot::Robot& robot_;
  const PlanOptions& options_;
  MotionCheck& check_;
  const Task& task_;
};

}  // namespace rangegrasp::planning::internal
