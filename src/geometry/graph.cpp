#include "geometry/graph.h"

#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>

namespace rangegrasp::geometry {
namespace {

/// The graph during contraction: the neighbors of each root and the summed weights to them.
class Contraction {
 public:
  Contraction(std::size_t nodes, std::span<const SignedEdge> edges)
      : sets_(nodes), neighbors_(nodes) {
    for (const SignedEdge& edge : edges) {
      if (edge.a >= nodes || edge.b >= nodes || !std::isfinite(edge.weight)) {
        throw std::invalid_argument("ContractGreedily: an edge names no node, or no weight");
      }
      if (edge.a == edge.b) continue;
      neighbors_[edge.a][edge.b] += edge.weight;
      neighbors_[edge.b][edge.a] += edge.weight;
    }
    for (std::uint32_t a = 0; a < nodes; ++a) {
      for (const auto& [b, weight] : neighbors_[a]) {
        if (a < b) Offer(a, b, weight);
      }
    }
  }

  UnionFind Run() {
    while (!queue_.empty()) {
      const auto [cost, a, b] = queue_.top();
      queue_.pop();
      // A candidate is outdated if its edge was contracted or summed since.
      const auto edge = neighbors_[a].find(b);
      if (edge != neighbors_[a].end() && edge->second == -cost) Join(a, b);
    }
    return std::move(sets_);
  }

 private:
  /// -weight, and the nodes a < b: the least is the next to be contracted.
  using Candidate = std::tuple<double, std::uint32_t, std::uint32_t>;

  void Offer(std::uint32_t a, std::uint32_t b, double weight) {
    if (weight > 0.0) queue_.emplace(-weight, std::min(a, b), std::max(a, b));
  }

  void Join(std::uint32_t a, std::uint32_t b) {
    sets_.Unite(a, b);
    const std::uint32_t kept = sets_.Find(a);
    const std::uint32_t gone = kept == a ? b : a;
    neighbors_[kept].erase(gone);
    for (const auto& [other, weight] : neighbors_[gone]) {
      if (other == kept) continue;
      neighbors_[other].erase(gone);
      const double sum = neighbors_[kept][other] += weight;
      neighbors_[other][kept] = sum;
      Offer(kept, other, sum);
    }
    neighbors_[gone].clear();
  }

  UnionFind sets_;
  std::vector<std::map<std::uint32_t, double>> neighbors_;
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> queue_;
};

}  // namespace

UnionFind ContractGreedily(std::size_t nodes, std::span<const SignedEdge> edges) {
  return Contraction(nodes, edges).Run();
}

Adjacency MakeAdjacency(std::span<const std::pair<std::uint32_t, std::uint32_t>> edges,
                        std::size_t nodes) {
  std::vector<std::uint32_t> end(nodes + 1, 0);  // of each node's list; at first, its size
  for (const auto& [a, b] : edges) ++end[a + 1];
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<std::uint32_t> to(edges.size());
  for (const auto& [a, b] : edges) to[end[a]++] = b;
  Adjacency adjacency;
  auto first = to.begin();
  for (std::size_t a = 0; a < nodes; ++a) {
    const auto last = to.begin() + end[a];
    std::sort(first, last);
    adjacency.to.insert(adjacency.to.end(), first, std::unique(first, last));
    adjacency.first.push_back(static_cast<std::uint32_t>(adjacency.to.size()));
    first = last;
  }
  return adjacency;
}

std::vector<double> DistancesFrom(std::span<const std::uint32_t> sources, const LinkRows& links) {
  std::vector<double> distance(links.begin.size() - 1, kFar);
  LowerDistances(sources, distance, [&links](std::uint32_t v, double d, const auto& reach) {
    for (std::uint32_t k = links.begin[v]; k < links.begin[v + 1]; ++k) {
      reach(links.neighbor[k], d + links.length[k]);
    }
  });
  return distance;
}

std::uint32_t FarthestReached(std::span<const double> distance) {
  const auto reached = [](double d) { return d < kFar ? d : -1.0; };
  const auto farthest = std::ranges::max_element(distance, {}, reached);
  return static_cast<std::uint32_t>(farthest - distance.begin());
}

}  // namespace rangegrasp::geometry
