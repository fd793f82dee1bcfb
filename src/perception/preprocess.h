#pragma once

#include <optional>

#include "core/rng.h"
#include "perception/scene.h"

namespace rangegrasp::perception {

/// Options of section 5.1.1 (and 4.2.1-4.2.2); defaults are the dissertation's for its scanner.
struct PreprocessOptions {
  double preselection_m = 0.005;  ///< distance to the deepest hull plane; points nearer are fitted
  int plane_draws = 100;
  double plane_distance_m = 0.002;  ///< inliers of the table plane
  double table_clearance_m =
      0.004;  ///< points lower than this above the table belong to it (see docs/architecture.md)
  bool filter = true;  ///< the compression-rate filter, eq. 4.5-4.9
  bool smooth = true;  ///< the average filter
  double smooth_radius_m = 0.003;
  double normal_radius_m = 0.005;  ///< local neighbourhood of the normals
  /// The direction away from the table where it is known; else the hull plane that the most points
  /// lie near is taken.
  std::optional<Eigen::Vector3d> up_C;
};

/// The deepest plane on the convex hull (eq. 5.1, figure 5.4), preselection, 100 hypotheses, refit
/// (section 5.1.1). The normal points to the sensor's side. Robust to a few outliers below the
/// table.
/// @return nullopt if no plane was found.
std::optional<Table> FindTable(geometry::PointSpan points_C, const Eigen::Vector3d& sensor_origin_C,
                               const PreprocessOptions& options, core::Rng& rng);

/// Eq. 4.5 to 4.7 from nearest-neighbour distances.
struct CompressionRate {
  double d_a_m = 0.0;  ///< (d_min + d_max) / 2, eq. 4.5
  double d_k_m = 0.0;  ///< mean, eq. 4.6
  double tau = 0.0;    ///< d_k / d_a, eq. 4.7
};
CompressionRate ComputeCompressionRate(double d_min_m, double d_max_m, double d_mean_m);

/// The outlier test, eq. 4.8 and 4.9: alpha = (d_a / N_a)^tau < beta = d_k / N_k; counts within
/// spheres of d_a and d_k.
bool IsOutlier(const CompressionRate& rate, std::size_t n_a, std::size_t n_k);

/// Positions of the points that the compression-rate filter keeps, ascending.
geometry::Indices CompressionRateFilter(geometry::PointSpan points);

/// The average filter: every point becomes the mean of its neighbours within the radius
/// (section 5.1.1).
geometry::Points Smooth(geometry::PointSpan points, double radius_m);

}  // namespace rangegrasp::perception
