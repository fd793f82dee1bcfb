#pragma once

#include "parts/cloud/cloud_sampling.h"

namespace rangegrasp::parts {

/// Whether noise is more than a quarter of the spacing of points: then neighborhoods of points are
/// slabs, no surfaces.
bool IsNoisy(const CloudSampling& sampling);

/// Evenly spread points of the surface that a cloud samples.
struct SurfacePoints {
  geometry::Points points;
  double spacing = 0.0;
  double noise = 0.0;  ///< of the cloud
};
/// Strays are left out, noise and spacing measured. Points are thinned to about 15,000 and moved
/// onto the surface as far as noise asks for: to the local plane (moving least squares, Alexa et
/// al. 2003), in a ball in which it is known to a slope of 0.1. O(n log n).
SurfacePoints PointsOfSurface(const geometry::Points& points);

}  // namespace rangegrasp::parts
