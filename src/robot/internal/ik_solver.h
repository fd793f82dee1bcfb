#pragma once

#include "robot/robot.h"

namespace rangegrasp::robot::internal {

struct IkTolerance {
  double position_m;
  double rotation_rad;
  int iterations;
};

/// Levenberg-Marquardt from q towards X_WH inside [lower, upper]; q holds the result. Damping is
/// half the squared error (Sugihara 2011); joints at a limit that the step would leave are held.
/// @return false if the tolerance was not met or the error stalled.
bool RefineIk(const Robot& robot, const base::Pose& X_WH, const Eigen::VectorXd& lower,
              const Eigen::VectorXd& upper, const IkTolerance& tolerance, Eigen::VectorXd& q);

}  // namespace rangegrasp::robot::internal
