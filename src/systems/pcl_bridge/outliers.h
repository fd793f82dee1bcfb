#pragma once

#include "pcl_bridge/cloud.h"

namespace rangegrasp::pcl_bridge {

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

struct RadiusFilterOptions {
  /// > 0. By default three times the spacing of the dissertation's scanner (1 mm).
  double radius_m = 0.003;
  /// >= 1, without the point itself. A point in the middle of a surface has about 28 at the spacing
  /// and radius above, one on its edge half of that, and one beyond a corner's still more than
  /// this.
  int min_neighbors = 4;
};

/// Positions of the points that stay, ascending: those with enough others within the radius
/// (RadiusOutlierRemoval). O(n log n).
/// @throws std::invalid_argument if an option is out of range.
geometry::Indices RadiusFilter(const Cloud& cloud, const RadiusFilterOptions& options = {});

}  // namespace rangegrasp::pcl_bridge
