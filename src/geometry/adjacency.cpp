#include "geometry/adjacency.h"

#include <algorithm>
#include <numeric>

namespace rangegrasp::geometry {

Adjacency MakeAdjacency(std::span<const std::pair<std::uint32_t, std::uint32_t>> edges,
                        std::size_t nodes) {
  Adjacency adjacency;
  adjacency.first.assign(nodes + 1, 0);
  for (const auto& [a, b] : edges) ++adjacency.first[a + 1];
  std::partial_sum(adjacency.first.begin(), adjacency.first.end(), adjacency.first.begin());
  adjacency.to.resize(edges.size());
  std::vector<std::uint32_t> at(adjacency.first.begin(), adjacency.first.end() - 1);
  for (const auto& [a, b] : edges) adjacency.to[at[a]++] = b;
  return adjacency;
}

Adjacency Unique(Adjacency adjacency) {
  Adjacency unique;
  unique.first.reserve(adjacency.first.size());
  unique.to.reserve(adjacency.to.size());
  for (std::uint32_t a = 0; a < adjacency.nodes(); ++a) {
    const auto begin = adjacency.to.begin() + adjacency.first[a];
    const auto end = adjacency.to.begin() + adjacency.first[a + 1];
    std::sort(begin, end);
    unique.to.insert(unique.to.end(), begin, std::unique(begin, end));
    unique.first.push_back(static_cast<std::uint32_t>(unique.to.size()));
  }
  return unique;
}

}  // namespace rangegrasp::geometry
