#pragma once

#include <vector>

#include "pcl_bridge/cloud.h"

namespace rangegrasp::pcl_bridge {

struct Normals {
  /// Unit vectors turned towards the cloud's origin, one a point; NaN where fewer than three points
  /// span no plane and where the point itself is not finite.
  geometry::Points directions;
  /// Surface variation l_0 / (l_0 + l_1 + l_2) of the eigenvalues l_0 <= l_1 <= l_2 of the
  /// neighborhood's covariance, in [0, 1/3]; NaN as above.
  std::vector<double> curvature;
};

struct NormalOptions {
  /// > 0. Larger evens out noise and rounds edges off. The dissertation's for its scanner
  /// (section 5.1.1).
  double radius_m = 0.005;
};

/// Normals by principal components of the points within the radius (NormalEstimation), O(n log n).
/// @throws std::invalid_argument if the radius is not > 0.
Normals EstimateNormals(const Cloud& cloud, const NormalOptions& options = {});

}  // namespace rangegrasp::pcl_bridge
