#include "parts/mirror/internal/space.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rangegrasp::parts {
namespace {

// The lowest 21 bits with two zeros before each.
std::uint64_t Spread(std::uint64_t x) {
  x = (x | x << 32U) & 0x001F00000000FFFFU;
  x = (x | x << 16U) & 0x001F0000FF0000FFU;
  x = (x | x << 8U) & 0x100F00F00F00F00FU;
  x = (x | x << 4U) & 0x10C30C30C30C30C3U;
  x = (x | x << 2U) & 0x1249249249249249U;
  return x;
}

}  // namespace

std::size_t CubeCell(const Eigen::Vector3d& direction, int side) {
  Eigen::Index axis = 0;
  const double largest = direction.cwiseAbs().maxCoeff(&axis);
  if (!(largest > 0.0)) return 0;
  const auto cell = [&](Eigen::Index i) {
    const double u = 0.5 * (1.0 + direction[(axis + i) % 3] / largest);
    return std::min(side - 1, static_cast<int>(u * side));
  };
  const int face = 2 * static_cast<int>(axis) + (direction[axis] > 0.0 ? 1 : 0);
  return static_cast<std::size_t>((face * side + cell(1)) * side + cell(2));
}

std::vector<std::uint32_t> SpatialOrder(geometry::PointSpan points) {
  if (points.empty()) return {};
  Eigen::Vector3d low = points.front();
  Eigen::Vector3d high = low;
  for (const Eigen::Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double extent = (high - low).maxCoeff();
  const double scale = extent > 0.0 ? 2097151.0 / extent : 0.0;  // 21 bits
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys;
  keys.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d u = (points[i] - low) * scale;
    const auto bits = [&u](int axis) { return Spread(static_cast<std::uint64_t>(u[axis])); };
    keys.emplace_back(bits(0) | bits(1) << 1U | bits(2) << 2U, i);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order;
  order.reserve(points.size());
  for (const auto& [key, i] : keys) order.push_back(i);
  return order;
}

}  // namespace rangegrasp::parts
