#pragma once

#include <optional>
#include <vector>

#include "base/rng.h"
#include "robot/robot.h"

namespace rangegrasp::robot {

struct IkOptions {
  int starts = 24;                       ///< random restarts after the seed itself
  int iterations = 60;                   ///< per start; those that stall end sooner
  double position_tolerance_m = 1e-5;    ///< far below the arm's repeatability
  double rotation_tolerance_rad = 1e-4;  ///< 0.02 mm at the fingertips, 0.2 m from the wrist
  double limit_margin_rad = 0.02;        ///< stay this far inside the joint limits
  double distinct_rad = 0.05;  ///< solutions that differ by less in every joint count as one
  std::size_t max_solutions = 8;
};

/// Damped least squares (Levenberg-Marquardt) with joint limits, from a seed and random restarts.
/// Joints with a range of several turns end within half a turn of the seed if possible.
/// @return the distinct solutions found, at most max_solutions, nearest to the seed first.
std::vector<Eigen::VectorXd> SolveIk(const Robot& robot, const base::Pose& X_WH,
                                     const Eigen::VectorXd& seed, const IkOptions& options,
                                     base::Rng& rng);

/// Moves the hand through the poses X_WH from q_start (near the first). Stays on one branch and
/// uses the redundancy to keep away from the limits. Returns one joint vector per pose, without
/// q_start; nullopt if a pose cannot be reached within the joint limits or a joint would jump.
std::optional<std::vector<Eigen::VectorXd>> FollowPoses(const Robot& robot,
                                                        const Eigen::VectorXd& q_start,
                                                        const std::vector<base::Pose>& poses_WH);

/// FollowPoses on a straight line in W (rotation by slerp) from X_WH(q_start) to X_WH, in steps of
/// at most step_m (or of step_m at kRotationRadius_m if it is mostly a rotation). Begins with
/// q_start.
std::optional<std::vector<Eigen::VectorXd>> StraightLine(const Robot& robot,
                                                         const Eigen::VectorXd& q_start,
                                                         const base::Pose& X_WH,
                                                         double step_m = 0.01);

}  // namespace rangegrasp::robot
