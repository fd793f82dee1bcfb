#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace rangegrasp::geometry {

/// Links in compressed rows: those of node v stand at [begin[v], begin[v + 1]).
struct LinkRows {
  std::span<const std::uint32_t> begin;  ///< nodes + 1
  std::span<const std::uint32_t> neighbor;
  std::span<const double> length;  ///< >= 0, parallel to neighbor
};

/// Dijkstra's algorithm (1959) from any number of sources; keeps its heap between calls.
///
/// A distance is the minimum, over all paths from a source, of the lengths added in the path's
/// order: rounding is monotone, so that neither the order of the sources nor that of the links
/// changes a bit of it, and sources may come in one call or one after the other.
///
/// A binary heap with stale entries left in: on meshes of six neighbors a node that is cheaper than
/// a heap with positions. O((n + links) log links).
class ShortestPaths {
 public:
  static constexpr double kFar = std::numeric_limits<double>::infinity();

  /// Lowers distance[v] to the distance from the nearest source wherever that is smaller (with all
  /// infinite before: the distances from the sources). A source at distance 0 already is done.
  ///
  /// @param expand  expand(v, d, reach) is called once for each node whose distance was lowered, by
  ///                rising (d, v), d its final distance. It calls reach(next, through) for each
  ///                neighbor with the length of the path through v, >= d; reach says whether
  ///                that lowered next's distance (ties: no), e.g. to hand on a label.
  /// @param max_distance  nodes farther than this keep the distance they were reached with and are
  ///                      not expanded.
  template <typename Expand>
  void Lower(std::span<const std::uint32_t> sources, std::span<double> distance, Expand expand,
             double max_distance = kFar) {
    heap_.clear();
    for (const std::uint32_t source : sources) Reach(source, 0.0, distance);
    Run(distance, expand, max_distance);
  }

  /// The same along links in rows.
  void Lower(std::span<const std::uint32_t> sources, const LinkRows& links,
             std::span<double> distance, double max_distance = kFar);

  /// The same from one node at any distance, below 0 too. `through` may be below d here: where it
  /// is always the same for the same node, the nodes come best first, each once.
  template <typename Expand>
  void LowerFrom(std::uint32_t source, double start, std::span<double> distance, Expand expand) {
    heap_.clear();
    Reach(source, start, distance);
    Run(distance, expand, kFar);
  }

 private:
  template <typename Expand>
  void Run(std::span<double> distance, Expand& expand, double max_distance) {
    while (!heap_.empty()) {
      std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
      const auto [d, v] = heap_.back();
      heap_.pop_back();
      if (d > max_distance) return;
      if (d > distance[v]) continue;
      expand(v, d,
             [&](std::uint32_t next, double through) { return Reach(next, through, distance); });
    }
  }

  bool Reach(std::uint32_t node, double through, std::span<double> distance) {
    if (through >= distance[node]) return false;
    distance[node] = through;
    heap_.emplace_back(through, node);
    std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
    return true;
  }

  std::vector<std::pair<double, std::uint32_t>> heap_;
};

/// Distances from the nearest of some sources; infinite where no links lead.
std::vector<double> DistancesFrom(std::span<const std::uint32_t> sources, const LinkRows& links);

/// The node of the largest finite distance; the lower number if two are as far, 0 if none is
/// finite.
std::uint32_t FarthestReached(std::span<const double> distance);

}  // namespace rangegrasp::geometry
