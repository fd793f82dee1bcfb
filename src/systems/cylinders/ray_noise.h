#pragma once

#include "cylinders/fit.h"

/// What the noise of a range sensor does to the distances of points from a barrel.
namespace rangegrasp::cylinders {

/// Noise of a range sensor's points: along the ray and square to it [m], standard deviations.
struct RayNoise {
  double along_m = 0.0;
  double across_m = 0.0;
};

/// How a ray meets a barrel, by the ray alone, so that the noise of the point on it plays no part:
/// of the ray's unit vector the part along the surface's normal there, and that along the surface
/// and square to the axis.
struct Incidence {
  double radial = 1.0;      ///< 0 to 1; 0 at the outline and beyond
  double tangential = 0.0;  ///< 0 to 1
};
Incidence IncidenceOf(const Barrel& barrel, const Eigen::Vector3d& eye, const Eigen::Vector3d& p);

/// What noise does to a point's distance from the barrel that it lies on, to second order: with s_n
/// and s_t the noise along the normal and along the tangent square to the axis,
///   mean = s_t^2 / (2 r)   (a step along the tangent leads out of a circle),
///   variance = s_n^2 + s_t^4 / (2 r^2).
struct DistanceNoise {
  double mean_m = 0.0;
  double variance_m2 = 0.0;
};
DistanceNoise DistanceNoiseOf(const RayNoise& noise, const Incidence& incidence, double radius_m);

}  // namespace rangegrasp::cylinders
