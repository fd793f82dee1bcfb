#pragma once

#include <cstdint>
#include <vector>

#include "geometry/point_cloud.h"

namespace rangegrasp::parts {

/// The cell of a direction on a cube whose faces are cut into side^2 cells; 0 for a zero vector.
std::size_t CubeCell(const Eigen::Vector3d& direction, int side);

/// The points along a Z-order curve (Morton 1966): what is near in space is near in memory, so that
/// searching a large cloud point after point does not wait for memory. O(n log n).
std::vector<std::uint32_t> SpatialOrder(geometry::PointSpan points);

}  // namespace rangegrasp::parts
