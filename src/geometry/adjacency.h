#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace rangegrasp::geometry {

/// The ends of the edges that leave each node of a graph, one list after the other: those of node a
/// are in `to` from first[a] to first[a + 1].
struct Adjacency {
  std::vector<std::uint32_t> first{0};
  std::vector<std::uint32_t> to;

  std::uint32_t nodes() const { return static_cast<std::uint32_t>(first.size() - 1); }
  std::span<const std::uint32_t> Of(std::uint32_t a) const {
    return std::span(to).subspan(first[a], first[a + 1] - first[a]);
  }
};

/// Each node's ends in the order of the edges (from, to). O(n) without a sort of all edges.
/// @param nodes  more than any edge names
Adjacency MakeAdjacency(std::span<const std::pair<std::uint32_t, std::uint32_t>> edges,
                        std::size_t nodes);

/// The same with each node's ends ascending, each once. O(n) for few edges a node.
Adjacency Unique(Adjacency adjacency);

}  // namespace rangegrasp::geometry
