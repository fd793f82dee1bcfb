#pragma once

#include <vector>

#include "geometry/kd_tree.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// Groups of points that hang together, each within link_m of another of its group [m]; in the
/// order of their first points, and so are the points of each. O(n log n) for few neighbors each.
/// @throws std::invalid_argument if a point is not finite.
std::vector<Points> GroupsWithin(const Points& points, double link_m);

/// The same as positions, with a tree over these points.
std::vector<Indices> GroupsWithin(PointSpan points, const KdTree& tree, double link_m);

}  // namespace rangegrasp::geometry
