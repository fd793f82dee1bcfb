#include "geometry/signed_graph.h"

#include <cmath>
#include <map>
#include <queue>
#include <stdexcept>
#include <utility>
#include <vector>

namespace rangegrasp::geometry {
namespace {

/// The graph while it is contracted: of each root, its neighbors and the summed weights to them.
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
      const Candidate best = queue_.top();
      queue_.pop();
      // A candidate whose edge was contracted or summed since is out of date.
      const auto edge = neighbors_[best.a].find(best.b);
      if (edge != neighbors_[best.a].end() && edge->second == best.weight) Join(best.a, best.b);
    }
    return std::move(sets_);
  }

 private:
  struct Candidate {
    double weight;
    std::uint32_t a;
    std::uint32_t b;
    bool operator<(const Candidate& other) const {
      if (weight != other.weight) return weight < other.weight;
      return std::pair(a, b) > std::pair(other.a, other.b);
    }
  };

  void Offer(std::uint32_t a, std::uint32_t b, double weight) {
    if (weight > 0.0) queue_.push({weight, std::min(a, b), std::max(a, b)});
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
  std::priority_queue<Candidate> queue_;
};

}  // namespace

UnionFind ContractGreedily(std::size_t nodes, std::span<const SignedEdge> edges) {
  return Contraction(nodes, edges).Run();
}

}  // namespace rangegrasp::geometry
