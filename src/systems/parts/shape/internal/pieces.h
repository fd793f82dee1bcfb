#pragma once

#include <cstdint>
#include <vector>

#include "geometry/union_find.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {

/// Connected pieces of the nodes of a graph (FaceGraph, VertexGraph): numbered from 0 by falling
/// size, ties by their first node. joined(a, b) says whether neighbors belong together. O(links).
/// @param chosen  nodes that count; the others get the label -1.
/// @return how many pieces there are.
template <typename Graph, typename Joined>
std::int32_t LabelPieces(const Graph& graph, const std::vector<bool>& chosen, Joined joined,
                         std::vector<std::int32_t>& label) {
  geometry::UnionFind sets(chosen.size());
  for (std::uint32_t v = 0; v < chosen.size(); ++v) {
    if (!chosen[v]) continue;
    for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
      const std::uint32_t next = graph.neighbor[k];
      if (chosen[next] && joined(v, next)) sets.Unite(v, next);
    }
  }
  return geometry::LabelBySize(sets, chosen, label);
}

/// The same of all neighbors that are chosen.
template <typename Graph>
std::int32_t LabelPieces(const Graph& graph, const std::vector<bool>& chosen,
                         std::vector<std::int32_t>& label) {
  return LabelPieces(
      graph, chosen, [](std::uint32_t, std::uint32_t) { return true; }, label);
}

/// The core, 0, and the connected pieces of the other faces, from 1 by falling size. Returns how
/// many pieces there are beside the core.
std::int32_t LabelOutside(const FaceGraph& faces, const std::vector<bool>& core,
                          std::vector<std::int32_t>& label);

/// Leaves of each label its largest connected piece (ties: that of the lowest face); other pieces
/// take the label they share most edges with, ties the lower one. Pieces without neighbors stay.
void JoinCrumbs(const FaceGraph& faces, std::vector<std::int32_t>& label);

}  // namespace rangegrasp::parts
