#pragma once

#include <cstdint>
#include <vector>

namespace rangegrasp::parts {

/// A link between two nodes, the same both ways; capacity >= 0.
struct CutLink {
  std::uint32_t a;
  std::uint32_t b;
  double capacity;
};

/// Source and sink where a caller has no other wish; its nodes count from 2.
inline constexpr std::uint32_t kSource = 0;
inline constexpr std::uint32_t kSink = 1;

/// The minimum cut between two nodes (Boykov and Kolmogorov 2004; Boost): true for the nodes on the
/// source's side. Capacities are rounded to a millionth of the largest, so that the flow is exact.
/// @throws std::invalid_argument if source equals sink or a node does not exist.
std::vector<bool> MinCut(std::uint32_t nodes, const std::vector<CutLink>& links,
                         std::uint32_t source, std::uint32_t sink);

}  // namespace rangegrasp::parts
