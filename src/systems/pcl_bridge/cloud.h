#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

#include "geometry/point_cloud.h"

namespace rangegrasp::pcl_bridge {

/// Points in the format of the Point Cloud Library, converted once for any number of calls.
///
/// The constructor copies the points in single precision, relative to `origin`, the viewpoint: the
/// library orients normals towards zero, and floats are most precise there (0.06 um at 1 m). Points
/// that are not finite are left out. Results refer to the given points: indices and labels are
/// positions in them, and coordinates are in their frame.
///
/// Immutable; a copy shares the points. The first one in a process permanently silences the
/// library's console messages. The results here contain the same information.
class Cloud {
 public:
  /// @param points  n >= 0 points [m]; not needed afterwards.
  /// @param origin  the sensor's position [m], in their frame.
  /// @throws std::invalid_argument if origin is not finite.
  explicit Cloud(geometry::PointSpan points,
                 const Eigen::Vector3d& origin = Eigen::Vector3d::Zero());

  /// The number of points given, finite or not.
  std::size_t size() const;
  const Eigen::Vector3d& origin() const;

  /// The points at these positions, without conversion to double. Their positions start at 0 again.
  /// @throws std::invalid_argument if a position is not below size().
  Cloud Select(std::span<const std::uint32_t> indices) const;

  /// For the module's own sources (internal/cloud_data.h).
  struct Data;
  explicit Cloud(std::shared_ptr<const Data> data) : data_(std::move(data)) {}
  const Data& data() const { return *data_; }

 private:
  std::shared_ptr<const Data> data_;
};

struct NormalOptions {
  /// > 0. A larger radius smooths noise and rounds edges. The dissertation's value for its scanner
  /// (section 5.1.1).
  double radius_m = 0.005;
};

/// Normals by principal component analysis of the points within the radius (NormalEstimation),
/// O(n log n).
/// @return one unit vector per point, towards the cloud's origin; NaN if fewer than three points
///         are within the radius or the point itself is not finite.
geometry::Points EstimateNormals(const Cloud& cloud, const NormalOptions& options = {});

struct StatisticalFilterOptions {
  int neighbors = 50;           ///< >= 1; in clouds with fewer other points, all of them
  double max_deviations = 1.0;  ///< >= 0; standard deviations above the mean
};

/// Positions of the points that are kept, ascending: those whose mean distance to their nearest
/// neighbors is at most the mean of this distance over all points plus max_deviations times its
/// standard deviation (StatisticalOutlierRemoval; Rusu et al. 2008). O(n log n).
geometry::Indices StatisticalFilter(const Cloud& cloud,
                                    const StatisticalFilterOptions& options = {});

}  // namespace rangegrasp::pcl_bridge
