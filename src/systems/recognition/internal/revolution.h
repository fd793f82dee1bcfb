#pragma once

#include <Eigen/Core>
#include <optional>

#include "geometry/point_cloud.h"

namespace rangegrasp::recognition::internal {

/// A line in the body's frame.
struct Axis {
  Eigen::Vector3d point_B;
  Eigen::Vector3d direction_B;  ///< unit
};

/// The axis that most of a surface turns about without leaving itself, such as a cup's, whose
/// handle does not: nullopt if less than 70 % of the surface does. The lines of the normals of a
/// surface of revolution meet its axis, a linear complex, which is found by least squares (Pottmann
/// and Randrup 1998, "Rotational and helical surface approximation for reverse engineering"),
/// weighted anew by the residuals.
/// @param surface_B  evenly sampled, with normals
std::optional<Axis> AxisOfRevolution(const geometry::PointCloud& surface_B);

}  // namespace rangegrasp::recognition::internal
