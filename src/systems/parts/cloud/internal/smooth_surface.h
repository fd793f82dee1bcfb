#pragma once

#include "parts/cloud/cloud_sampling.h"

namespace rangegrasp::parts {

/// Points of the surface that a cloud samples, about `max_points` at most, nowhere denser than that
/// asks for, with the noise taken out. In the order of a grid.
geometry::Points SmoothSurface(const geometry::Points& points, const CloudSampling& sampling,
                               int max_points);

/// Some of the points, no two of them nearer than `distance` to each other, so that no other could
/// be added; the first come first.
geometry::Points SpreadOut(const geometry::Points& points, double distance);

/// Side of the cubes of which one point is kept.
double ThinnedSpacing(std::size_t points, const CloudSampling& sampling, int max_points);

}  // namespace rangegrasp::parts
