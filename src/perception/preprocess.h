#pragma once

#include "perception/perception_options.h"
#include "perception/scene.h"

namespace rangegrasp::perception {

/// The deepest plane on the convex hull (eq. 5.1, figure 5.4), preselection, 100 hypotheses, refit
/// (section 5.1.1). The normal points to the sensor's side.
///
/// Among the hull's planes with the sensor on their inner side (and a normal near up_C), the one
/// with the most points near it wins. Stray points under the table bend the hull: if the plane has
/// points beneath it or little support, the hull's vertices are removed and the hull is built
/// again, a bounded number of times. With a background behind and under the table, the dominant
/// plane is taken (section 4.2.1). Table::points are all points less than table_clearance_m above
/// the plane, and all below it (eq. 4.3, 4.4). O(n log n).
/// @param sensor_origin_C  the sensor's position, or any other place on its side of the table
/// @return nullopt if no plane was found.
std::optional<Table> FindTable(geometry::PointSpan points_C, const Eigen::Vector3d& sensor_origin_C,
                               const PreprocessOptions& options, base::Rng& rng);

/// The table of a plane: all points less than table_clearance_m above it.
Table TableOn(const geometry::Plane& plane, geometry::PointSpan points_C,
              const PreprocessOptions& options);

/// Eq. 4.5 to 4.7 from nearest-neighbor distances.
struct CompressionRate {
  double d_a_m = 0.0;  ///< (d_min + d_max) / 2, eq. 4.5
  double d_k_m = 0.0;  ///< mean, eq. 4.6
  double tau = 0.0;    ///< d_k / d_a, eq. 4.7
};
CompressionRate ComputeCompressionRate(double d_min_m, double d_max_m, double d_mean_m);

/// alpha = (d_a / N_a)^tau, eq. 4.8; n_a counts the points within d_a, including the point itself.
/// The value depends on the unit of length; the dissertation's is the millimetre.
double OutlierAlpha(const CompressionRate& rate, std::size_t n_a, double unit_m = 0.001);
/// beta = d_k / N_k, eq. 4.9, in that unit; n_k counts the points within d_k, including itself.
double OutlierBeta(const CompressionRate& rate, std::size_t n_k, double unit_m = 0.001);

/// The outlier test: alpha < beta.
bool IsOutlier(const CompressionRate& rate, std::size_t n_a, std::size_t n_k,
               double unit_m = 0.001);

/// d_a / N_a > d_k / N_k: the large sphere has fewer points than even a straight line of points as
/// dense as in the small sphere would have. On a surface, N grows with the square of the radius.
bool IsIsolated(const CompressionRate& rate, std::size_t n_a, std::size_t n_k);

/// Extensions beyond eq. 4.5-4.9 (see CompressionRateFilter); both off: as printed.
struct OutlierFilterOptions {
  bool isolated_only = true;
  bool repeated = true;
  double unit_m = 0.001;  ///< the unit of length of eq. 4.8
  double keep_m = 0.0;    ///< a point with a neighbor nearer than this is no outlier
};

/// Positions of the points that the compression-rate filter keeps, ascending. It removes the points
/// for which IsOutlier holds and, with isolated_only, IsIsolated too.
///
/// Why both: alpha falls as N_a grows, so the printed test alone also holds for points of a dense
/// surface whose nearest neighbor is farther than the mean, which are about half of all points if
/// one far outlier makes d_a large. The dissertation's filter removed 38 of 22,377 points. One far
/// outlier also hides nearer ones, so with `repeated` the filter repeats until it removes nothing,
/// at most 20 times. O(n log n) in the first pass, O(n) in the others.
geometry::Indices CompressionRateFilter(geometry::PointSpan points,
                                        const OutlierFilterOptions& options = {});

/// The average filter (section 5.1.1): every point becomes the mean of its neighbors within the
/// radius, including itself.
geometry::Points Smooth(geometry::PointSpan points, double radius_m);

}  // namespace rangegrasp::perception
