#include "geometry/point_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>

namespace rangegrasp::geometry {
namespace {

constexpr double kLevels = 255.0;

double LightOfLevel(double level) {
  const double share = level / kLevels;
  return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
}

/// The nearest level. Its table saves powers, an eighth of the time of a colored depth image.
std::uint8_t LevelOf(double light) {
  static const auto ends = [] {  // of the range of light of each level but the last
    std::array<double, 255> lights{};
    for (std::size_t i = 0; i < lights.size(); ++i) {
      lights[i] = LightOfLevel(static_cast<double>(i) + 0.5);
    }
    return lights;
  }();
  return static_cast<std::uint8_t>(std::ranges::upper_bound(ends, light) - ends.begin());
}

}  // namespace

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

Eigen::Vector3d LightOf(const Rgb& color) {
  static const std::array<double, 256> table = [] {
    std::array<double, 256> lights{};
    for (std::size_t i = 0; i < lights.size(); ++i)
      lights[i] = LightOfLevel(static_cast<double>(i));
    return lights;
  }();
  return {table[color[0]], table[color[1]], table[color[2]]};
}

Rgb ColorOf(const Eigen::Vector3d& light) {
  return {LevelOf(light.x()), LevelOf(light.y()), LevelOf(light.z())};
}

}  // namespace rangegrasp::geometry
