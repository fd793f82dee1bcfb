#pragma once

#include <vector>

#include "geometry/union_find.h"
#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// The parts in sets, numbered by falling area, ties by their first parts. The tree is the whole
/// and what it came to.
/// @param area  of each part
Segmentation JoinParts(const Segmentation& found, const std::vector<double>& area,
                       geometry::UnionFind& sets);

}  // namespace rangegrasp::parts
