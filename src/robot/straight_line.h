#pragma once

#include <optional>
#include <vector>

#include "robot/robot.h"

namespace rangegrasp::robot {

/// How joint paths follow the hand's poses.
struct FollowOptions {
  /// A joint moves no further from one pose to the next: one that does has changed its branch, or
  /// passes a singular pose.
  double max_jump_rad = 0.2;
  /// Of the step within the null space at a joint's limit. Larger: the arm leaves the limits
  /// sooner, and turns its elbow more on the way.
  double null_space_step_rad = 0.02;
  double position_tolerance_m = 1e-6;
  double rotation_tolerance_rad = 1e-5;
  int iterations = 20;  ///< near the solution, every one about doubles the digits
};

/// Moves the hand through the poses X_WH one after the other from q_start (a pose near the first),
/// staying on one branch and using the redundancy to keep off the limits: one joint vector a pose,
/// q_start not among them. nullopt if a pose cannot be met within the joint limits or a joint would
/// jump.
std::optional<std::vector<Eigen::VectorXd>> FollowPoses(const Robot& robot,
                                                        const Eigen::VectorXd& q_start,
                                                        const std::vector<base::Pose>& poses_WH,
                                                        const FollowOptions& options = {});

/// Moves the hand on a straight line in W (rotation by slerp) from X_WH(q_start) to X_WH, by steps
/// of at most step_m (or of step_m at kRotationRadius_m where the line is mostly a turn), as
/// FollowPoses does. The first joint vector is q_start. nullopt if the line leaves the joint limits
/// or jumps.
std::optional<std::vector<Eigen::VectorXd>> StraightLine(const Robot& robot,
                                                         const Eigen::VectorXd& q_start,
                                                         const base::Pose& X_WH,
                                                         double step_m = 0.01);

}  // namespace rangegrasp::robot
