#pragma once

#include <Eigen/Core>
#include <vector>

#include "geometry/point_cloud.h"

namespace rangegrasp::recognition::internal {

/// A flat face of a convex hull, in the frame B of its points.
struct HullFace {
  Eigen::Vector3d normal_B = Eigen::Vector3d::Zero();  ///< unit, outward
  double offset_m = 0.0;                               ///< normal . x on it
  double area_m2 = 0.0;
  geometry::Points corners_B;  ///< of its triangles, in no order
};

/// The hull's triangles, joined to faces where they are coplanar within 2 deg; in an order that
/// depends on the points alone.
std::vector<HullFace> HullFaces(geometry::PointSpan points_B);

/// Directions (unit, in B) that may point down when the body lies on a plane: the faces over which
/// the middle of the hull stands, or misses by at most slack_m. What a body weighs where is not
/// known, hence the slack.
std::vector<Eigen::Vector3d> LyingDirections(geometry::PointSpan points_B, double slack_m);

}  // namespace rangegrasp::recognition::internal
