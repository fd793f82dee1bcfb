#pragma once

#include <vector>

#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts::samples {

/// The graph with the given neighbor lists; every link has length 1.
inline VertexGraph GraphOf(const std::vector<std::vector<std::uint32_t>>& links) {
  VertexGraph graph;
  graph.begin.push_back(0);
  for (const auto& some : links) {
    graph.neighbor.insert(graph.neighbor.end(), some.begin(), some.end());
    graph.length.insert(graph.length.end(), some.size(), 1.0);
    graph.begin.push_back(static_cast<std::uint32_t>(graph.neighbor.size()));
  }
  return graph;
}

}  // namespace rangegrasp::parts::samples
