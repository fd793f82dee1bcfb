#pragma once

#include "geometry/point_cloud.h"

namespace rangegrasp::parts {

/// The volume of water that a surface holds when a direction points up, by priority flooding of its
/// upper side (Barnes et al. 2014): over each cell of a grid the water stands as high as the
/// lowest rim on the way out. What is unseen within a rim is taken as deep as the deepest that is
/// seen.
/// @param points  of the surface, no more apart than a cell: its extent across / `cells`
/// O(n + cells^2 log cells).
double HeldWater(geometry::PointSpan points, const Eigen::Vector3d& up, int cells = 24);

}  // namespace rangegrasp::parts
