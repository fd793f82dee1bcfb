#pragma once

#include <vector>

#include "geometry/kd_tree.h"

namespace rangegrasp::parts {

/// How a cloud samples a surface.
struct CloudSampling {
  double spacing = 0.0;  ///< root of the area that a point stands for
  double noise = 0.0;    ///< standard deviation of the points about the surface, along its normal
};
/// Measured at about a thousand of the points, in balls so large that they hold the surface's
/// neighborhood however thick noise made it: noise is the residual of a quadric (with six degrees
/// of freedom less than points), spacing comes from their number. Medians, so that creases, thin
/// walls and strays count little.
/// @param tree  of the points, >= 1
CloudSampling MeasureSampling(const geometry::Points& points, const geometry::KdTree& tree);

/// Points that do not lie on the surface: those that fewer than a few others lie about, within a
/// ball that would hold dozens if it were on it, and those in pieces as small.
std::vector<bool> StrayPoints(const geometry::Points& points, const geometry::KdTree& tree,
                              const CloudSampling& sampling);

}  // namespace rangegrasp::parts
