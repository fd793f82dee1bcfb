#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/frames.h"
#include "robot/robot.h"

namespace rangegrasp::robot {

/// A joint path by arc length s [rad]: straight pieces joined by circular arcs (Kunz and Stilman
/// 2012, eq. 2-8).
struct PathPiece {
  double length = 0.0;
  double radius = 0.0;           ///< 0: straight
  Eigen::VectorXd origin;        ///< straight: its start; arc: its centre
  Eigen::VectorXd start, along;  ///< unit; arc: from centre to start, and the start's direction
  bool stop_before = false;      ///< the corner cannot be rounded: come to rest

  Eigen::VectorXd Position(double s) const;
  Eigen::VectorXd Tangent(double s) const;    ///< dq/ds
  Eigen::VectorXd Curvature(double s) const;  ///< d2q/ds2
};

/// Rounds the corners of a polyline; the rounded path deviates from each by at most corner_rad.
std::vector<PathPiece> RoundCorners(const std::vector<Eigen::VectorXd>& waypoints,
                                    double corner_rad);

struct TimingOptions {
  double velocity_scale = 1.0;  ///< of the published limits, in (0, 1]
  double acceleration_scale = 1.0;
  double period_s = 0.01;     ///< of the samples; the servo interpolates them every 2 ms
  double corner_rad = 0.05;   ///< how far the rounding may deviate from a corner (2-norm)
  double smoothing_s = 0.08;  ///< moving average over time: bounds the jerk by 2 a / smoothing_s
};

/// Time-parameterises a joint path under the robot's velocity and acceleration limits. The motion
/// is at rest at both ends, and the samples there are exact. Corners become circular arcs (Kunz and
/// Stilman 2012). The speed along the path is the fastest allowed (reachability analysis on a grid,
/// Pham and Pham 2018). A moving average over smoothing_s bounds the jerk and keeps all limits.
/// Each joint deviates from the path by at most corner_rad + acceleration * smoothing_s^2 / 24.
/// @param path  at least one joint vector; straight joint lines in between.
base::JointTrajectory TimeParameterise(const Robot& robot, const std::vector<Eigen::VectorXd>& path,
                                       const TimingOptions& options);

}  // namespace rangegrasp::robot
