#pragma once

#include "geometry/kd_tree.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// Unit normals by principal components of the points within radius_m (section 4.2.2,
/// eq. 4.10-4.12), turned to the side of `origin`. A point with fewer than three neighbours takes
/// the normal of its nearest three.
Points EstimateNormals(PointSpan points, const KdTree& tree, double radius_m,
                       const Eigen::Vector3d& origin);

}  // namespace rangegrasp::geometry
