#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace rangegrasp::geometry {

using Points = std::vector<Eigen::Vector3d>;
using PointSpan = std::span<const Eigen::Vector3d>;
/// Indices of points in a cloud.
using Indices = std::vector<std::uint32_t>;

/// Points [m] in one frame; normals are absent or one per point (unit length).
struct PointCloud {
  Points points;
  Points normals;

  std::size_t size() const { return points.size(); }
};

/// The indices of the items that fulfil a condition, ascending.
template <typename Items, typename Holds>
Indices PositionsWhere(const Items& items, const Holds& holds) {
  Indices found;
  std::uint32_t i = 0;
  for (const auto& item : items) {
    if (holds(item)) found.push_back(i);
    ++i;
  }
  return found;
}
/// The indices of the marks that are set, ascending.
inline Indices PositionsOf(const std::vector<bool>& marks) {
  return PositionsWhere(marks, [](bool mark) { return mark; });
}

/// Indices of the points in lexicographic order of their coordinates, ties by index.
template <class PointsOf>
Indices CanonicalOrder(const PointsOf& points) {
  Indices order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, [&points](std::uint32_t a, std::uint32_t b) {
    const auto& p = points[a];
    const auto& q = points[b];
    if (p == q) return a < b;
    return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
  });
  return order;
}

/// For each point the first point with the same coordinates.
template <class PointsOf>
Indices FirstTwin(const PointsOf& points, const Indices& order) {
  Indices twin(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && points[order[i]] == points[order[i - 1]];
    twin[order[i]] = same ? twin[order[i - 1]] : order[i];
  }
  return twin;
}

/// points[indices[0]], points[indices[1]], ...
Points Select(PointSpan points, std::span<const std::uint32_t> indices);

/// The mean of n >= 1 points.
/// @throws std::invalid_argument if there is none.
Eigen::Vector3d Centroid(PointSpan points);

/// Red, green and blue as in images (sRGB, 8 bits each).
using Rgb = std::array<std::uint8_t, 3>;

/// The linear light of a color, each channel 0..1 (IEC 61966-2-1).
Eigen::Vector3d LightOf(const Rgb& color);
/// The nearest color for a linear light; values above 1 are clipped.
Rgb ColorOf(const Eigen::Vector3d& light);

}  // namespace rangegrasp::geometry
