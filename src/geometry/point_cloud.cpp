#include "geometry/point_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

namespace rangegrasp::geometry {
namespace {

constexpr double kLevels = 255.0;

double LightOfLevel(double level) {
  const double share = level / kLevels;
  return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
}

/// The nearest level. A table gives the first one of a step of light: powers took an eighth of the
/// time of a colored depth image.
std::uint8_t LevelOf(double light) {
  constexpr std::size_t kSteps = 1024;
  static const auto begins = [] {  // of each level; of the one after the last, never
    std::array<double, 257> lights{};
    for (std::size_t i = 1; i < 256; ++i) lights[i] = LightOfLevel(static_cast<double>(i) - 0.5);
    lights[256] = std::numeric_limits<double>::infinity();
    return lights;
  }();
  static const auto first = [] {  // level at the begin of each step of light
    std::array<std::uint8_t, kSteps + 1> levels{};
    for (std::size_t k = 0; k <= kSteps; ++k) {
      const double begin = static_cast<double>(k) / kSteps;
      levels[k] =
          static_cast<std::uint8_t>(std::ranges::upper_bound(begins, begin) - begins.begin() - 1);
    }
    return levels;
  }();
  const double clipped = std::clamp(light, 0.0, 1.0);
  std::uint8_t level = first[static_cast<std::size_t>(clipped * kSteps)];
  while (clipped >= begins[level + 1U]) ++level;
  return level;
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
