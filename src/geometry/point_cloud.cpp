#include "geometry/point_cloud.h"

#include <stdexcept>

namespace rangegrasp::geometry {

Points Select(PointSpan points, std::span<const std::uint32_t> indices) {
  Points selected;
  selected.reserve(indices.size());
  for (const std::uint32_t i : indices) selected.push_back(points[i]);
  return selected;
}

Eigen::Vector3d Centroid(PointSpan points) {
  if (points.empty()) throw std::invalid_argument("Centroid: there is no point");
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

}  // namespace rangegrasp::geometry
