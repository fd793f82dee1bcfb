#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <span>
#include <utility>
#include <vector>

namespace rangegrasp::geometry {

/// Disjoint sets over 0 .. n - 1, by size with path halving (Tarjan 1975): near-constant time.
class UnionFind {
 public:
  explicit UnionFind(std::size_t n) : parent_(n), size_(n, 1) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }

  std::uint32_t Find(std::uint32_t i) {
    while (parent_[i] != i) {
      parent_[i] = parent_[parent_[i]];
      i = parent_[i];
    }
    return i;
  }

  /// Joins the sets of a and b; false if they were already one set.
  bool Unite(std::uint32_t a, std::uint32_t b) {
    a = Find(a);
    b = Find(b);
    if (a == b) return false;
    if (size_[a] < size_[b]) std::swap(a, b);
    parent_[b] = a;
    size_[a] += size_[b];
    return true;
  }

  std::size_t size() const { return parent_.size(); }

 private:
  std::vector<std::uint32_t> parent_;
  std::vector<std::uint32_t> size_;
};

/// Numbers the sets 0, 1, ... by descending count of their used members, ties by first member, in
/// `label` (-1 for unused members). @return the number of sets
inline std::int32_t LabelBySize(UnionFind& sets, const std::vector<bool>& used,
                                std::vector<std::int32_t>& label) {
  const auto n = static_cast<std::uint32_t>(sets.size());
  std::vector<std::uint32_t> count(n, 0);
  std::vector<std::uint32_t> roots;  // in the order of their first members
  for (std::uint32_t i = 0; i < n; ++i) {
    if (used[i] && count[sets.Find(i)]++ == 0) roots.push_back(sets.Find(i));
  }
  std::stable_sort(roots.begin(), roots.end(),
                   [&count](std::uint32_t a, std::uint32_t b) { return count[a] > count[b]; });
  std::vector<std::int32_t> rank(n, -1);
  for (std::size_t k = 0; k < roots.size(); ++k) rank[roots[k]] = static_cast<std::int32_t>(k);
  label.assign(n, -1);
  for (std::uint32_t i = 0; i < n; ++i) {
    if (used[i]) label[i] = rank[sets.Find(i)];
  }
  return static_cast<std::int32_t>(roots.size());
}

/// Evidence that two nodes belong together (weight > 0) or do not (weight < 0).
struct SignedEdge {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  double weight = 0.0;
};

/// Partitions a graph of signed edges by greedy additive edge contraction (Keuper et al. 2015,
/// "Efficient decomposition of image and mesh graphs by lifted multicuts", algorithm 1): the edge
/// with the largest weight is contracted, parallel edges are summed, until none is positive. A
/// border outweighs a leak of few edges. Ties go to the lower nodes; edges may repeat. O(m log m).
/// @return the parts as sets of nodes 0 .. nodes - 1
/// @throws std::invalid_argument if an edge names an invalid node or its weight is not finite.
UnionFind ContractGreedily(std::size_t nodes, std::span<const SignedEdge> edges);

/// The end nodes of the edges that leave each node of a graph, in concatenated lists: those of node
/// a are in `to` from first[a] to first[a + 1].
struct Adjacency {
  std::vector<std::uint32_t> first{0};
  std::vector<std::uint32_t> to;

  std::uint32_t nodes() const { return static_cast<std::uint32_t>(first.size() - 1); }
  std::span<const std::uint32_t> Of(std::uint32_t a) const {
    return std::span(to).subspan(first[a], first[a + 1] - first[a]);
  }
};

/// Each node's end nodes by edges (from, to), ascending and unique. O(n) for few edges per node.
/// @param nodes  number of nodes, greater than any node of an edge
Adjacency MakeAdjacency(std::span<const std::pair<std::uint32_t, std::uint32_t>> edges,
                        std::size_t nodes);

/// Links in compressed sparse rows: those of node v are at [begin[v], begin[v + 1]).
struct LinkRows {
  std::span<const std::uint32_t> begin;  ///< nodes + 1 entries
  std::span<const std::uint32_t> neighbor;
  std::span<const double> length;  ///< >= 0, parallel to neighbor
};

/// The distance of a node that no path leads to.
constexpr double kFar = std::numeric_limits<double>::infinity();

/// Dijkstra's algorithm (1959) from any number of sources: lowers distance[v] to the distance from
/// the nearest source wherever that is smaller; if all are infinite before, to all distances.
/// Rounding is monotone, so distances are bit-identical for any order of sources and links, and for
/// sources in one call or in several. Stale entries stay in the heap: on meshes this is cheaper
/// than a heap with positions. O((n + links) log links).
/// @param expand  expand(v, d, reach) is called once for each node whose distance was lowered, in
/// ascending order of (d, v), where d is its final distance. It calls reach(next, through) for each
/// neighbor with the length of the path through v, >= d; reach returns whether it lowered next's
/// distance (ties: no), e.g. to pass on a label. If `through` is instead a value >= 0 of next
/// alone, the nodes are visited best first, each once.
/// @param max_distance  nodes farther than this keep the distance they were reached with and are
/// not expanded.
template <typename Expand>
void LowerDistances(std::span<const std::uint32_t> sources, std::span<double> distance,
                    Expand expand, double max_distance = kFar) {
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> heap;
  const auto reach = [&](std::uint32_t node, double through) {
    if (through >= distance[node]) return false;
    distance[node] = through;
    heap.emplace(through, node);
    return true;
  };
  for (const std::uint32_t source : sources) reach(source, 0.0);
  while (!heap.empty()) {
    const auto [d, v] = heap.top();
    heap.pop();
    if (d > max_distance) return;
    if (d == distance[v]) expand(v, d, reach);
  }
}

/// Distances from the nearest source; infinite for nodes that no links lead to.
std::vector<double> DistancesFrom(std::span<const std::uint32_t> sources, const LinkRows& links);

/// The (lowest) node with the largest finite distance; 0 if none is finite.
std::uint32_t FarthestReached(std::span<const double> distance);

}  // namespace rangegrasp::geometry
