#pragma once

#include "geometry/kd_tree.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// Unit normals by principal components of the points within radius_m (section 4.2.2,
/// eq. 4.10-4.12), turned to the side of the place that the point was seen from. A point with fewer
/// than three neighbors takes the normal of its nearest three.
/// @param places  where the sensors stood
/// @param place_of  one a point: position in places
Points EstimateNormals(PointSpan points, const KdTree& tree, double radius_m, PointSpan places,
                       std::span<const std::uint32_t> place_of);
/// The same where all points were seen from one place.
Points EstimateNormals(PointSpan points, const KdTree& tree, double radius_m,
                       const Eigen::Vector3d& origin);

}  // namespace rangegrasp::geometry
