#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "geometry/point_cloud.h"

namespace rangegrasp::parts {

/// Triangles through evenly spread points of a surface, turned alike where they touch: the
/// advancing front of Cohen-Steiner and Da (2004; CGAL). Gaps wider than max_edge stay open.
/// Depends on the points and their order alone: ties go by numbers, not by addresses as CGAL's own.
std::vector<std::array<std::uint32_t, 3>> AdvancingFront(const geometry::Points& points,
                                                         double max_edge);

}  // namespace rangegrasp::parts
