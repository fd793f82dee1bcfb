#include "pcl_bridge/internal/pcl_cloud.h"

#include <pcl/console/print.h>

#include <algorithm>
#include <mutex>

namespace rangegrasp::pcl_bridge {

FinitePoints::FinitePoints(geometry::PointSpan given, const Eigen::Vector3d& origin) {
  Demand(origin.allFinite(), "a cloud's origin must be finite");
  static std::once_flag silenced;
  std::call_once(silenced, [] { pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); });
  points->reserve(given.size());
  source.reserve(given.size());
  for (std::size_t i = 0; i < given.size(); ++i) {
    if (!given[i].allFinite()) continue;
    const Eigen::Vector3f p = (given[i] - origin).cast<float>();
    points->push_back({p.x(), p.y(), p.z()});
    source.push_back(static_cast<std::uint32_t>(i));
  }
}

geometry::Indices ToSource(const geometry::Indices& source, const pcl::Indices& indices) {
  geometry::Indices positions;
  positions.reserve(indices.size());
  for (const auto k : indices) positions.push_back(source[static_cast<std::size_t>(k)]);
  std::ranges::sort(positions);
  return positions;
}

}  // namespace rangegrasp::pcl_bridge
