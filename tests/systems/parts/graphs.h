#pragma once

#include <Eigen/Core>
#include <algorithm>
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

/// Lowers the lengths of single links to the shortest distances (Floyd and Warshall).
inline void Shorten(Eigen::MatrixXd& d) {
  for (Eigen::Index k = 0; k < d.rows(); ++k) {
    for (Eigen::Index i = 0; i < d.rows(); ++i) {
      for (Eigen::Index j = 0; j < d.rows(); ++j) d(i, j) = std::min(d(i, j), d(i, k) + d(k, j));
    }
  }
}

}  // namespace rangegrasp::parts::samples
