#pragma once

#include <Eigen/Core>

#include "cylinders/axis_fit.h"
#include "geometry/point_cloud.h"

/// Fits of one cylinder to the points of its seen side, compared by tables 4.3 and 4.4.
namespace rangegrasp::cylinders {

/// The barrel of a cylinder, unbounded along its axis.
struct Barrel {
  Line axis;
  double radius_m = 0.0;

  /// Distance of p from the barrel [m], below 0 inside: the euclidean distance of section 2.5.1 to
  /// the wall of eq. 2.14, |(I - d d^T)(p - c)| - r.
  double Distance(const Eigen::Vector3d& p) const { return axis.Distance(p) - radius_m; }
};

struct BarrelFit {
  Barrel barrel;
  int iterations = 0;  ///< that were made: fewer than granted where the fit had come to rest
};

/// What every fit is given: points of one object, as one sensor sees them.
struct FitInput {
  geometry::PointSpan points;                     ///< [m], finite
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();  ///< where the sensor stood
  Eigen::Vector3d up = Eigen::Vector3d::UnitX();  ///< unit; out of the table
};

/// Angle between two axes, whatever their signs [rad], 0 to pi / 2.
double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace rangegrasp::cylinders
