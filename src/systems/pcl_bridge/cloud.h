#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

#include "geometry/point_cloud.h"

namespace rangegrasp::pcl_bridge {

/// Points as the Point Cloud Library keeps them, made once and given to any number of calls.
///
/// Making one copies, in single precision relative to `origin`, the place that they were seen from:
/// the library turns normals towards zero, and floats are finest there (0.06 um at 1 m). Points
/// that are not finite are left out. Results count as if none of this were so: indices and labels
/// are positions in the points given, lengths and places are in their frame.
///
/// Immutable; a copy shares the points. The first one made in a process silences the library's
/// messages on the console for good: what they would say is in the results here.
class Cloud {
 public:
  /// @param points  n >= 0 points [m]; not needed afterwards.
  /// @param origin  where the sensor stood [m], in their frame.
  /// @throws std::invalid_argument if origin is not finite.
  explicit Cloud(geometry::PointSpan points,
                 const Eigen::Vector3d& origin = Eigen::Vector3d::Zero());

  /// The number of points given, finite or not.
  std::size_t size() const;
  const Eigen::Vector3d& origin() const;

  /// The points at these positions, without the way through doubles; they count anew from 0.
  /// @throws std::invalid_argument if a position is not below size().
  Cloud Select(std::span<const std::uint32_t> indices) const;

  /// What the module's sources see of it (internal/cloud_data.h).
  struct Data;
  explicit Cloud(std::shared_ptr<const Data> data) : data_(std::move(data)) {}
  const Data& data() const { return *data_; }

 private:
  std::shared_ptr<const Data> data_;
};

struct NormalOptions {
  /// > 0. Larger evens out noise and rounds edges off. The dissertation's for its scanner
  /// (section 5.1.1).
  double radius_m = 0.005;
};

/// Normals by principal components of the points within the radius (NormalEstimation), O(n log n).
/// @return unit vectors turned towards the cloud's origin, one a point; NaN where fewer than three
///         points span no plane and where the point itself is not finite.
/// @throws std::invalid_argument if the radius is not > 0.
geometry::Points EstimateNormals(const Cloud& cloud, const NormalOptions& options = {});

struct StatisticalFilterOptions {
  int neighbors = 50;           ///< >= 1; of clouds with fewer other points, all of them
  double max_deviations = 1.0;  ///< >= 0; standard deviations above the mean
};

/// Positions of the points that stay, ascending: those whose mean distance to their nearest
/// neighbors is at most the mean of this number over all points plus max_deviations of its standard
/// deviations (StatisticalOutlierRemoval; Rusu et al. 2008). O(n log n).
/// @throws std::invalid_argument if an option is out of range.
geometry::Indices StatisticalFilter(const Cloud& cloud,
                                    const StatisticalFilterOptions& options = {});

}  // namespace rangegrasp::pcl_bridge
