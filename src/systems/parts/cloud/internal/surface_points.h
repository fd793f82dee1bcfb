#pragma once

#include "geometry/kd_tree.h"
#include "parts/shape/shape.h"

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
CloudSampling MeasureSampling(const Points& points, const geometry::KdTree& tree);

/// Points that do not lie on the surface: those that fewer than a few others lie about, within a
/// ball that would hold dozens if it were on it, and those in pieces as small.
std::vector<bool> StrayPoints(const Points& points, const geometry::KdTree& tree,
                              const CloudSampling& sampling);

/// Whether noise is more than a quarter of the spacing of points: then neighborhoods of points are
/// slabs, no surfaces.
bool IsNoisy(const CloudSampling& sampling);

/// Evenly spread points of the surface that a cloud samples.
struct SurfacePoints {
  Points points;
  double spacing = 0.0;
  double noise = 0.0;  ///< of the cloud
};
/// Strays are left out, noise and spacing measured. Points are thinned to about 15,000 and moved
/// onto the surface as far as noise asks for: to the local plane (moving least squares, Alexa et
/// al. 2003), in a ball in which it is known to a slope of 0.1. O(n log n).
SurfacePoints PointsOfSurface(const Points& points);

}  // namespace rangegrasp::parts
