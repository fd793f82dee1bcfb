#pragma once

#include <optional>

#include "base/frames.h"
#include "geometry/observation.h"

namespace rangegrasp::views {

/// A view moved as a rigid body: its points, where they were seen from, and its pose.
geometry::View Moved(geometry::View view, const base::Pose& X_by);

/// How far a view's pose may be off, against the views before it: root mean square distance and
/// angle, about where the sensor stood.
struct PoseError {
  double shift_m = 0.002;
  double turn_rad = 0.004;
};

struct RefineOptions {
  PoseError error;
  /// Of a point's nearest one across its surface, and aside along it: further off it is of another
  /// surface, or the silhouette of one that was not seen before.
  double max_across_m = 0.010;
  double max_aside_m = 0.005;
  /// Of a point's normal. Smaller: the noise of normals tells of shifts along a plane what nothing
  /// can tell (at 10 mm more than the arm's own word, at 20 mm a tenth of it).
  double normal_radius_m = 0.020;
  /// Of the view, and three times as many of the earlier ones, evenly: more tell nothing new, since
  /// neighbors share their errors.
  std::size_t max_points = 4000;
  /// So many neighboring points have one error in common (speckle, jitter, mixed points). Larger:
  /// what is seen has to tell more to count against the arm's word.
  double points_a_fact = 10.0;
  int max_iterations = 20;
  double min_step_m = 1e-5;  ///< it ends with a smaller step: far below the noise
  /// Of a correction, in deviations of the error: 1 in 3,000 honest ones is larger (chi squared,
  /// 6).
  double max_deviations = 5.0;
};

/// What came of laying a view onto the ones before.
struct Refinement {
  base::Pose X_by = base::Pose::Identity();  ///< the correction, to be given to Moved
  bool refined = false;     ///< if not: nothing in common, or further off than the error allows
  double sigma_m = 0.0;     ///< of the pairs across the surface, after it, from their median
  std::size_t pairs = 0;    ///< that it rests on
  double deviations = 0.0;  ///< the size of the correction in deviations of the error
};

/// Iterated closest points (Chen and Medioni 1991) with what the arm says as a prior: over pairs of
/// points p of the view and q, n (normal) of the earlier ones it seeks the shift t and turn w about
/// the sensor's place o that minimise
///   sum (n . (p + t + w x (p - o) - q))^2 / (k sigma^2) + (t, w)' P^-1 (t, w)
/// with k points a fact, sigma the pairs' own deviation, Cauchy's weights, and P the covariance of
/// the error. What the overlap leaves open (the place of a plane along itself) stays as the arm
/// says; PCL's registration, without a prior, slid along the table by many times the error.
/// O(n log n).
/// @param region_C  points outside are left out
Refinement Refine(const geometry::Observation& earlier, const geometry::View& view,
                  const Eigen::AlignedBox3d& region_C, const RefineOptions& options);

}  // namespace rangegrasp::views
