#include "pcl_bridge/cloud.h"

#include <pcl/console/print.h>
#include <pcl/features/normal_3d.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/search/kdtree.h>

#include <algorithm>
#include <limits>
#include <mutex>

#include "pcl_bridge/internal/cloud_data.h"

namespace rangegrasp::pcl_bridge {

Cloud::Cloud(geometry::PointSpan points, const Eigen::Vector3d& origin) {
  Demand(origin.allFinite(), "a cloud's origin must be finite");
  static std::once_flag silenced;
  std::call_once(silenced, [] { pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); });
  auto data = std::make_shared<Data>();
  data->size = points.size();
  data->origin = origin;
  data->finite->reserve(points.size());
  data->source.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) continue;
    const Eigen::Vector3f p = (points[i] - origin).cast<float>();
    data->finite->push_back({p.x(), p.y(), p.z()});
    data->source.push_back(static_cast<std::uint32_t>(i));
  }
  data_ = std::move(data);
}

std::size_t Cloud::size() const { return data_->size; }
const Eigen::Vector3d& Cloud::origin() const { return data_->origin; }

Cloud Cloud::Select(std::span<const std::uint32_t> indices) const {
  constexpr auto kNone = static_cast<std::uint32_t>(-1);
  geometry::Indices finite_of(size(), kNone);
  for (std::uint32_t k = 0; k < data_->source.size(); ++k) finite_of[data_->source[k]] = k;
  auto chosen = std::make_shared<Data>();
  chosen->size = indices.size();
  chosen->origin = data_->origin;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    Demand(indices[i] < size(), "Cloud::Select: a position lies behind the cloud's last point");
    const std::uint32_t k = finite_of[indices[i]];
    if (k == kNone) continue;
    chosen->finite->push_back((*data_->finite)[k]);
    chosen->source.push_back(static_cast<std::uint32_t>(i));
  }
  return Cloud(std::move(chosen));
}

geometry::Indices ToSource(const Cloud& cloud, const pcl::Indices& indices) {
  geometry::Indices source;
  source.reserve(indices.size());
  for (const auto k : indices) source.push_back(cloud.data().source[static_cast<std::size_t>(k)]);
  std::ranges::sort(source);
  return source;
}

geometry::Points EstimateNormals(const Cloud& cloud, const NormalOptions& options) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  geometry::Points normals(cloud.size(), Eigen::Vector3d::Constant(kNaN));
  const Cloud::Data& data = cloud.data();
  if (data.finite->empty()) return normals;
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(data.finite);
  estimation.setSearchMethod(pcl::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  estimation.setRadiusSearch(options.radius_m);
  pcl::PointCloud<pcl::Normal> found;
  estimation.compute(found);
  for (std::size_t k = 0; k < found.size(); ++k) {
    normals[data.source[k]] = found[k].getNormalVector3fMap().cast<double>().normalized();
  }
  return normals;
}

geometry::Indices StatisticalFilter(const Cloud& cloud, const StatisticalFilterOptions& options) {
  const auto& points = cloud.data().finite;
  // The library divides by the number of points minus one and assumes that all neighbors exist.
  if (points->size() < 3) return cloud.data().source;
  pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
  filter.setMeanK(std::min(options.neighbors, static_cast<int>(points->size()) - 1));
  filter.setStddevMulThresh(options.max_deviations);
  filter.setInputCloud(points);
  pcl::Indices kept;
  filter.filter(kept);
  return ToSource(cloud, kept);
}

}  // namespace rangegrasp::pcl_bridge
