#include "pcl_bridge/cloud.h"

#include <pcl/console/print.h>

#include <algorithm>
#include <cmath>

#include "pcl_bridge/internal/cloud_data.h"

namespace rangegrasp::pcl_bridge {
namespace {

void Silence() {
  static const bool once = [] {
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
    return true;
  }();
  (void)once;
}

pcl::PointXYZ ToPcl(const Eigen::Vector3d& p) {
  const Eigen::Vector3f f = p.cast<float>();
  return {f.x(), f.y(), f.z()};
}

}  // namespace

Cloud::Cloud(geometry::PointSpan points, const Eigen::Vector3d& origin) {
  Demand(origin.allFinite(), "a cloud's origin must be finite");
  Silence();
  auto data = std::make_shared<Data>();
  data->size = points.size();
  data->origin = origin;
  data->finite->reserve(points.size());
  data->source.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) continue;
    data->finite->push_back(pcl_bridge::ToPcl(points[i] - origin));
    data->source.push_back(static_cast<std::uint32_t>(i));
  }
  data_ = std::move(data);
}

std::size_t Cloud::size() const { return data_->size; }
const Eigen::Vector3d& Cloud::origin() const { return data_->origin; }

Cloud Cloud::Select(std::span<const std::uint32_t> indices) const {
  constexpr auto kNone = static_cast<std::uint32_t>(-1);
  std::vector<std::uint32_t> finite_of(size(), kNone);
  for (std::size_t k = 0; k < data_->source.size(); ++k) {
    finite_of[data_->source[k]] = static_cast<std::uint32_t>(k);
  }
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

std::vector<geometry::Indices> ToSource(const Cloud& cloud,
                                        const std::vector<pcl::PointIndices>& clusters) {
  std::vector<geometry::Indices> source;
  source.reserve(clusters.size());
  for (const auto& cluster : clusters) source.push_back(ToSource(cloud, cluster.indices));
  return source;
}

OrientedCloud WithNormals(const Cloud& cloud, const Normals& normals) {
  Demand(normals.directions.size() == cloud.size() && normals.curvature.size() == cloud.size(),
         "there must be one normal and one curvature for each point of the cloud");
  const Cloud::Data& all = cloud.data();
  auto data = std::make_shared<Cloud::Data>();
  data->size = all.size;
  data->origin = all.origin;
  const PclNormals::Ptr converted(new PclNormals);
  for (std::size_t k = 0; k < all.source.size(); ++k) {
    const auto i = all.source[k];
    if (!normals.directions[i].allFinite() || !std::isfinite(normals.curvature[i])) continue;
    const Eigen::Vector3f n = normals.directions[i].cast<float>();
    converted->push_back({n.x(), n.y(), n.z(), static_cast<float>(normals.curvature[i])});
    data->finite->push_back((*all.finite)[k]);
    data->source.push_back(i);
  }
  return {Cloud(std::move(data)), converted};
}

}  // namespace rangegrasp::pcl_bridge
