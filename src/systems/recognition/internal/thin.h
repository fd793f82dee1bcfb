#pragma once

#include "geometry/point_cloud.h"

namespace rangegrasp::recognition::internal {

/// Positions of the first point in each cell of a grid of this edge [m], ascending.
geometry::Indices Thinned(geometry::PointSpan points, double edge_m);

}  // namespace rangegrasp::recognition::internal
