#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/point_cloud.h"

namespace rangegrasp::geometry::internal {

/// Cuts a polygon into triangles of the same turn and appends them: a quad along the diagonal from
/// its hollow corner, or from its first; one of more corners by a constrained Delaunay
/// triangulation in its mean plane. One that crosses itself becomes a fan. O(n log n).
/// @param corners  positions in `points`, finite; of less than three nothing is made.
void AppendTriangles(const Points& points, std::span<const std::uint32_t> corners,
                     std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace rangegrasp::geometry::internal
