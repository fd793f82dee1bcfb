#pragma once

#include <cstdint>
#include <vector>

#include "geometry/kd_tree.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// The components of BuildAlphaComplex alone, several times faster on scans: most points are joined
/// by triangles that their nearest neighbors prove to be in the complex, and only where sets stay
/// apart at less than 2 alpha is the triangulation built (the source says why that is exact).
struct AlphaComponents {
  std::vector<std::int32_t> component;  ///< as in AlphaComplex
  std::int32_t components = 0;
};
/// @param tree  over these points.
AlphaComponents FindAlphaComponents(PointSpan points, const KdTree& tree, double alpha_m);

}  // namespace rangegrasp::geometry
