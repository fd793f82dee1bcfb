#pragma once

#include <cstdint>
#include <span>

#include "geometry/union_find.h"

namespace rangegrasp::geometry {

/// How much speaks for two nodes being one (weight > 0), or against it (< 0).
struct SignedEdge {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  double weight = 0.0;
};

/// Parts a graph whose edges speak for and against: greedy additive edge contraction (Keuper et al.
/// 2015, "Efficient decomposition of image and mesh graphs by lifted multicuts", algorithm 1). The
/// edge with the largest weight is contracted, edges that become parallel are summed, until none is
/// positive. So a leak of a few edges between two bodies is outvoted by the rest of their border,
/// where connected components would join them. Ties go to the lower nodes; edges may repeat.
/// O(m log m).
/// @return the parts as sets of nodes 0 .. nodes - 1
/// @throws std::invalid_argument if an edge names no node or its weight is not finite.
UnionFind ContractGreedily(std::size_t nodes, std::span<const SignedEdge> edges);

}  // namespace rangegrasp::geometry
