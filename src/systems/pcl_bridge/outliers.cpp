#include "pcl_bridge/outliers.h"

#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/filters/statistical_outlier_removal.h>

#include <algorithm>

#include "pcl_bridge/internal/cloud_data.h"

namespace rangegrasp::pcl_bridge {

geometry::Indices StatisticalFilter(const Cloud& cloud, const StatisticalFilterOptions& options) {
  Demand(options.neighbors >= 1, "StatisticalFilter: neighbors must be >= 1");
  Demand(options.max_deviations >= 0.0, "StatisticalFilter: max_deviations must be >= 0");
  const auto& points = cloud.data().finite;
  // The library divides by the number of points less one, and by neighbors that may not be there.
  if (points->size() < 3) return cloud.data().source;
  pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
  filter.setMeanK(std::min(options.neighbors, static_cast<int>(points->size()) - 1));
  filter.setStddevMulThresh(options.max_deviations);
  filter.setInputCloud(points);
  pcl::Indices kept;
  filter.filter(kept);
  return ToSource(cloud, kept);
}

geometry::Indices RadiusFilter(const Cloud& cloud, const RadiusFilterOptions& options) {
  Demand(options.radius_m > 0.0, "RadiusFilter: radius_m must be > 0");
  Demand(options.min_neighbors >= 1, "RadiusFilter: min_neighbors must be >= 1");
  const auto& points = cloud.data().finite;
  if (points->empty()) return {};
  pcl::RadiusOutlierRemoval<pcl::PointXYZ> filter;
  filter.setRadiusSearch(options.radius_m);
  filter.setMinNeighborsInRadius(options.min_neighbors);
  filter.setInputCloud(points);
  pcl::Indices kept;
  filter.filter(kept);
  return ToSource(cloud, kept);
}

}  // namespace rangegrasp::pcl_bridge
