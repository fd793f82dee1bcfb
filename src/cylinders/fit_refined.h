#pragma once

#include <optional>

#include "cylinders/fit.h"

/// A barrel refined by orthogonal distances, each weighed by what a range sensor's noise makes of
/// it. An addition to the dissertation.
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

struct RefineOptions {
  /// Whether distances are weighed by their variance at their incidence; false: all alike. With it
  /// the outline, where noise runs along the surface, says most of the radius.
  bool weigh_incidence = true;
  /// Whether the mean of DistanceNoise is taken off each distance; false: the radius comes out
  /// larger by about that, which matters where the noise is not small against the radius.
  bool correct_mean = true;
  /// Whether the seen end and what is about its rim are left out; false: the robust loss alone has
  /// to do it, and cannot tell the end's outermost points from the wall.
  bool drop_ends = true;
  /// Tukey's biweight: distances beyond so many standard deviations do not count. 4.685 keeps 95 %
  /// of least squares' efficiency where the noise is normal (Huber 1981); smaller throws out more
  /// of what is no barrel.
  double cut_sigmas = 4.685;
  /// Points nearer to a seen end than this many noises along the ray are left out.
  double end_margin_sigmas = 4.0;
  /// An end is seen where this share of the points lies within the barrel by more than
  /// inner_share of its radius.
  double end_share = 0.01;
  double inner_share = 0.25;
  int rounds = 60;       ///< >= 1; weights, then a Gauss-Newton step
  double rest_m = 1e-9;  ///< ends where no point of the barrel moves by more
};

/// The barrel near `start` with the least robust, weighted sum of squared distances. The noise
/// along and across the rays is estimated from the points' own distances in each round. O(rounds
/// n).
/// @param start  off by less than about a quarter of the radius.
/// @return nullopt for fewer than seven points within the cut, or where the result is no cylinder.
/// @throws std::invalid_argument if an option is out of range.
std::optional<BarrelFit> FitRefined(const FitInput& input, const Barrel& start,
                                    const RefineOptions& options = {});

}  // namespace rangegrasp::cylinders
