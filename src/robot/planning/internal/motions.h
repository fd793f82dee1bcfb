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
  /// Moves a uniform sample to where paths are worth looking for; may be empty.
  std::function<void(Eigen::VectorXd&)> project;
  double resolution_rad = 0.04;
  int iterations = 1500;
  double seconds = 2.0;  ///< wall time
};

/// Waypoints from start to goal: the straight line where it is free, else RRTConnect (Kuffner and
/// LaValle 2000, from OMPL) with shortcuts. nullopt if none was found.
std::optional<JointPath> PlanJointPath(const robot::Robot& robot, const JointQuery& query,
                                       base::Rng& rng);

/// What a stage of the motion may touch, and how far its hand may lean.
struct Stage {
  collision::Contacts contacts;
  double min_upright = -1.0;  ///< the cosine of the hand's largest tilt away from up_H
  Eigen::Vector3d up_H = Eigen::Vector3d::UnitZ();
};

/// Whether `free` holds along the joint line, at steps of resolution_rad, without its first end.
bool EdgeFree(const std::function<bool(const Eigen::VectorXd&)>& free, const Eigen::VectorXd& from,
              const Eigen::VectorXd& to, double resolution_rad);

/// Joint limits, tilt and collisions along joint paths.
class MotionCheck {
 public:
  MotionCheck(const robot::Robot& robot, double margin_m, double cell_margin_m = 0.0)
      : robot_(robot), collider_(robot, margin_m, cell_margin_m) {}

  collision::RobotCollider& collider() { return collider_; }

  /// Whether q is within the limits, upright enough and touches nothing that the stage forbids.
  bool Free(const Eigen::VectorXd& q, const Stage& stage);
  /// Why q is not free: what touches what, or which limit it leaves; empty where it is.
  std::string WhyNot(const Eigen::VectorXd& q, const Stage& stage);
  /// The same for the joint lines between the path's points, at steps of resolution_rad.
  bool PathFree(const JointPath& path, const Stage& stage, double resolution_rad);

 private:
  const robot::Robot& robot_;
  collision::RobotCollider collider_;
};

/// What one request asks of every branch of the inverse kinematics.
struct Task {
  base::Pose X_WH;
  Eigen::Vector3d approach_W;
  Eigen::Vector3d center_W;     ///< of the object, as it stands
  Eigen::Vector3d delivered_W;  ///< the same point when it is let go
  Eigen::Vector3d base_W;       ///< the arm's, that carries turn about
  double approach_m = 0.0, lift_m = 0.0;
  double below_m = 0.0;  ///< that a standing object reaches below what was seen of it
  std::size_t open_state = 0, closed_state = 0;  ///< of HandModel::states
  bool may_brush = false;                        ///< PickRequest
};

/// Where everything goes: the object's middle, and how deep it may be lowered.
Task MakeTask(const robot::Robot& robot, const PlanningScene& scene, const PickRequest& request,
              const PlanOptions& options, const collision::RobotCollider& collider);

/// The turns about the vertical [rad] that a delivery may have, least turning of the wrist first:
/// as the object goes round the base, plus k * 2 pi / count.
std::vector<double> DeliveryYaws(const Task& task, int count);

/// The hand's pose on the way from the grasp's attitude to the delivery: at share t of the way
/// round the base, dz above the height it was grasped at.
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
  /// @param why  where it is not free: what touches what
  bool Approach(Branch& branch, std::string& why) const;
  bool Lift(Branch& branch) const;
  /// On an arc round the base at the lifted height, then down and away: the first yaw that works.
  bool CarryOnArc(Branch& branch) const;
  /// Lowering and retreat from branch.carry.back().
  bool LowerAndRetreat(double yaw_rad, Branch& branch) const;

  /// With the hand open, before the grasp and away from it.
  Stage ReachStage() const;
  /// With the object in the hand; nothing that was perceived may be touched. Clear of the work cell
  /// by the margin unless the object stood nearer to it, so that it is nearer where it was lifted.
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
