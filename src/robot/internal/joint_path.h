#pragma once

#include <Eigen/Core>
#include <vector>

namespace rangegrasp::robot::internal {

/// A joint path by arc length s [rad]: straight pieces joined by circular arcs (Kunz and Stilman
/// 2012, eq. 2-8).
struct PathPiece {
  double length = 0.0;
  double radius = 0.0;           ///< 0: straight
  Eigen::VectorXd origin;        ///< straight: its start; arc: its centre
  Eigen::VectorXd start, along;  ///< unit; arc: from centre to start, and the start's direction
  bool stop_before = false;      ///< a corner that cannot be rounded: come to rest

  Eigen::VectorXd Position(double s) const;
  Eigen::VectorXd Tangent(double s) const;    ///< dq/ds
  Eigen::VectorXd Curvature(double s) const;  ///< d2q/ds2
};

/// Rounds the corners of a polyline so that the rounded path leaves each by at most corner_rad.
std::vector<PathPiece> RoundCorners(const std::vector<Eigen::VectorXd>& waypoints,
                                    double corner_rad);

}  // namespace rangegrasp::robot::internal
