#pragma once

#include "parts/shape/clean_shape.h"

namespace rangegrasp::parts {

/// Whether a point is inside a shape. Mesh: generalised winding number (Jacobson et al. 2013) of at
/// least one half, with its pieces turned outwards first, so that open, self-intersecting and badly
/// oriented meshes have an answer too. Cloud: points lie in at least half of all directions from
/// it.
bool IsInside(const Shape& shape, const Eigen::Vector3d& p);

}  // namespace rangegrasp::parts
