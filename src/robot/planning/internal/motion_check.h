#pragma once

#include <functional>
#include <string>
#include <vector>

#include "robot/collision/robot_collider.h"

namespace rangegrasp::planning::internal {

/// What a stage of the motion may touch, and how far its hand may lean.
struct Stage {
  collision::Contacts contacts;
  double min_upright = -1.0;  ///< the cosine of the hand's largest tilt away from up_H
  Eigen::Vector3d up_H = Eigen::Vector3d::UnitZ();
};

/// Whether `free` holds along the straight joint line, at steps of resolution_rad, without its
/// first end.
bool EdgeFree(const std::function<bool(const Eigen::VectorXd&)>& free, const Eigen::VectorXd& from,
              const Eigen::VectorXd& to, double resolution_rad);

/// Joint limits, tilt and collisions along joint paths.
class MotionCheck {
 public:
  MotionCheck(const robot::Robot& robot, double margin_m)
      : robot_(robot), collider_(robot, margin_m) {}

  collision::RobotCollider& collider() { return collider_; }

  /// Whether q is within the limits, upright enough and touches nothing that the stage forbids.
  bool Free(const Eigen::VectorXd& q, const Stage& stage);
  /// Why q is not free: what touches what, or which limit it leaves; empty where it is.
  std::string WhyNot(const Eigen::VectorXd& q, const Stage& stage);
  /// The same for the joint lines between the path's points, at steps of resolution_rad.
  bool PathFree(const std::vector<Eigen::VectorXd>& path, const Stage& stage,
                double resolution_rad);

 private:
  const robot::Robot& robot_;
  collision::RobotCollider collider_;
};

}  // namespace rangegrasp::planning::internal
