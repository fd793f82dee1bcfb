#include "parts/shape/shape_graph.h"

#include <gtest/gtest.h>

#include <map>

#include "base/rng.h"
#include "parts/graphs.h"

namespace rangegrasp::parts {
namespace {

/// A random graph with links in both directions.
VertexGraph RandomGraph(std::uint32_t nodes, base::Rng& rng) {
  std::vector<std::vector<std::uint32_t>> links(nodes);
  for (std::uint32_t i = 0; i < nodes; ++i) {
    const auto a = static_cast<std::uint32_t>(rng.Index(nodes));
    const auto b = static_cast<std::uint32_t>(rng.Index(nodes));
    links[a].push_back(b);
    links[b].push_back(a);
  }
  return samples::GraphOf(links);
}

class SeededPieces : public ::testing::TestWithParam<std::uint64_t> {};

// Reference: every node takes the lowest number among its neighbors until nothing changes.
TEST_P(SeededPieces, AreWhatNeighborsReachFallingBySize) {
  base::Rng rng(GetParam());
  const VertexGraph graph = RandomGraph(40, rng);
  std::vector<bool> chosen(40), color(40);
  for (std::size_t v = 0; v < 40; ++v) chosen[v] = rng.Uniform() < 0.8;
  for (std::size_t v = 0; v < 40; ++v) color[v] = rng.Uniform() < 0.5;
  const auto joined = [&](std::uint32_t a, std::uint32_t b) { return color[a] == color[b]; };
  const auto& [label, pieces] = ConnectedPieces(graph, chosen, joined);

  std::vector<std::uint32_t> low(40);
  for (std::uint32_t v = 0; v < 40; ++v) low[v] = v;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::uint32_t v = 0; v < 40; ++v) {
      for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
        const std::uint32_t u = graph.neighbor[k];
        if (!chosen[v] || !chosen[u] || !joined(v, u) || low[u] >= low[v]) continue;
        low[v] = low[u];
        changed = true;
      }
    }
  }
  std::map<std::uint32_t, int> size;
  for (std::uint32_t v = 0; v < 40; ++v) size[low[v]] += chosen[v] ? 1 : 0;
  std::erase_if(size, [](const auto& one) { return one.second == 0; });
  EXPECT_EQ(static_cast<std::size_t>(pieces), size.size());
  for (std::uint32_t v = 0; v < 40; ++v) {
    EXPECT_EQ(label[v] < 0, !chosen[v]);
    for (std::uint32_t u = 0; u < v; ++u) {
      if (!chosen[u] || !chosen[v]) continue;
      EXPECT_EQ(label[u] == label[v], low[u] == low[v]);
      // Larger pieces come first; of two equally large pieces, the one with the first node.
      const auto key = [&](auto node) {
        return std::pair(-static_cast<double>(size[low[node]]), low[node]);
      };
      if (key(u) < key(v)) {
        EXPECT_LT(label[u], label[v]);
      }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Seeds, SeededPieces, ::testing::Range<std::uint64_t>(1, 51));

}  // namespace
}  // namespace rangegrasp::parts
