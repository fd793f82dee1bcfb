#pragma once

#include <cstddef>

#include "base/frames.h"
#include "geometry/observation.h"

namespace rangegrasp::views {

/// Moves a view as a rigid body: its points, their viewpoints, and its pose.
geometry::View Moved(geometry::View view, const base::Pose& X_by);

struct RefineOptions {
  /// Error of the view's pose relative to the earlier views: root mean square distance and angle,
  /// about the sensor's position.
  double shift_error_m = 0.002;
  double turn_error_rad = 0.004;
  /// Maximum distance of a point from its nearest one, along the normal and along the surface.
  /// Points further off belong to another surface, or to a silhouette that was not seen before.
  double max_across_m = 0.010;
  double max_aside_m = 0.005;
  /// Radius of the normals. Smaller: their noise appears as information about shifts along a plane,
  /// of which there is none (at 10 mm more than from the arm's pose, at 20 mm a tenth of that).
  double normal_radius_m = 0.020;
  /// Evenly chosen points of the view, and three times as many of the earlier ones. More add no
  /// information, since neighbors share their errors.
  std::size_t max_points = 4000;
  /// Number of neighboring points that share one error (speckle, jitter, mixed points). Larger:
  /// more overlap is needed to outweigh the arm's pose.
  double points_a_fact = 10.0;
  int max_iterations = 20;
  double min_step_m = 1e-5;  ///< stops at smaller steps: far below the noise
  /// Maximum correction, in standard deviations of the error: 1 in 3,000 valid ones is larger (chi
  /// squared, 6 degrees of freedom).
  double max_deviations = 5.0;
};

/// Result of aligning a view with the earlier ones.
struct Refinement {
  base::Pose X_by = base::Pose::Identity();  ///< the correction, to be passed to Moved
  bool refined = false;     ///< false: no overlap, or off by more than the error allows
  double sigma_m = 0.0;     ///< of the pairs along the normal, after it, from their median
  std::size_t pairs = 0;    ///< number of pairs used
  double deviations = 0.0;  ///< size of the correction in standard deviations of the error
};

/// Iterative closest point (Chen and Medioni 1991) with the arm's pose as a prior. Over pairs of
/// points p of the view and q, n (normal) of the earlier ones, it finds the shift t and rotation w
/// about the sensor's position o that minimize
///   sum (n . (p + t + w x (p - o) - q))^2 / (k sigma^2) + (t, w)' P^-1 (t, w)
/// with k = points_a_fact, sigma the standard deviation of the pairs, Cauchy weights, and P the
/// covariance of the error. Directions that the overlap does not determine (a plane along itself)
/// keep the arm's pose. PCL's registration, without a prior, slid along the table by many times the
/// error. O(n log n).
/// @param region_C  points outside are ignored
Refinement Refine(const geometry::Observation& earlier, const geometry::View& view,
                  const Eigen::AlignedBox3d& region_C, const RefineOptions& options);

}  // namespace rangegrasp::views
