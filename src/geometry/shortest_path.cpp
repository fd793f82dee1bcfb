#include "geometry/shortest_path.h"

namespace rangegrasp::geometry {

void ShortestPaths::Lower(std::span<const std::uint32_t> sources, const LinkRows& links,
                          std::span<double> distance, double max_distance) {
  Lower(
      sources, distance,
      [&links](std::uint32_t v, double d, const auto& reach) {
        for (std::uint32_t k = links.begin[v]; k < links.begin[v + 1]; ++k) {
          reach(links.neighbor[k], d + links.length[k]);
        }
      },
      max_distance);
}

std::vector<double> DistancesFrom(std::span<const std::uint32_t> sources, const LinkRows& links) {
  std::vector<double> distance(links.begin.size() - 1, ShortestPaths::kFar);
  ShortestPaths().Lower(sources, links, distance);
  return distance;
}

std::uint32_t FarthestReached(std::span<const double> distance) {
  std::uint32_t best = 0;
  double far = -1.0;
  for (std::uint32_t v = 0; v < distance.size(); ++v) {
    if (distance[v] > far && distance[v] < ShortestPaths::kFar) {
      far = distance[v];
      best = v;
    }
  }
  return best;
}

}  // namespace rangegrasp::geometry
