#pragma once

#include <optional>

#include "cylinders/fit.h"
#include "cylinders/ray_noise.h"

/// A barrel refined by orthogonal distances, each weighed by what a range sensor's noise makes of
/// it. An addition to the dissertation.
namespace rangegrasp::cylinders {

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
