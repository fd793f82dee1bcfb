#pragma once

#include <vector>

#include "base/rng.h"
#include "robot/robot.h"

namespace rangegrasp::robot {

struct IkOptions {
  int starts = 24;                       ///< random restarts after the seed itself
  int iterations = 60;                   ///< of one start; those that stall end sooner
  double position_tolerance_m = 1e-5;    ///< far below what the arm repeats
  double rotation_tolerance_rad = 1e-4;  ///< 0.02 mm at the fingertips, 0.2 m from the wrist
  double limit_margin_rad = 0.02;        ///< stay this far inside the joint limits
  double distinct_rad = 0.05;  ///< solutions with no joint further apart than this are one
  std::size_t max_solutions = 8;
};

/// Damped least squares (Levenberg-Marquardt) with joint limits from a seed and random restarts; a
/// joint that may turn more than once is turned back to within half a turn of the seed where it
/// can.
/// @return all distinct solutions found up to max_solutions, nearest to the seed first; empty if
/// none.
std::vector<Eigen::VectorXd> SolveIk(const Robot& robot, const base::Pose& X_WH,
                                     const Eigen::VectorXd& seed, const IkOptions& options,
                                     base::Rng& rng);

}  // namespace rangegrasp::robot
