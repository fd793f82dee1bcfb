#include "parts/hierarchy/internal/best_split.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/units.h"

namespace rangegrasp::parts {
namespace {

using Cell = std::uint32_t;

/// Share of a side's area in cells at the part's own edge from which it is a strip.
constexpr double kStrip = 0.5;

std::vector<bool> Members(const Cells& part, const CellSet& set) {
  std::vector<bool> in(part.size(), false);
  for (const Cell c : set) in[c] = true;
  return in;
}

double AreaOf(const Cells& part, const CellSet& set) {
  double area = 0.0;
  for (const Cell c : set) area += part.area[c];
  return area;
}

double BorderCost(const Cells& part, const CellSet& piece, const std::vector<bool>& candidate) {
  double cost = 0.0;
  for (const Cell c : piece) {
    for (const Cells::Link& link : part.links[c]) {
      if (candidate[link.to] != candidate[c]) cost += link.cost;
    }
  }
  return cost;
}

/// The share of a side's area in cells at the part's own edge.
double EdgeShare(const Cells& part, const std::vector<bool>& in, bool side) {
  double area = 0.0;
  double at_edge = 0.0;
  for (Cell c = 0; c < part.size(); ++c) {
    if (in[c] != side) continue;
    area += part.area[c];
    if (part.on_edge[c]) at_edge += part.area[c];
  }
  return at_edge / area;
}

/// Cells on both sides of the border, and all that touch them: cells may follow each other along a
/// border without that they share an edge.
std::vector<bool> AtBorder(const Cells& part, const std::vector<bool>& off) {
  std::vector<bool> border(part.size(), false);
  for (Cell c = 0; c < part.size(); ++c) {
    for (const Cells::Link& link : part.links[c]) {
      if (off[c] != off[link.to]) border[c] = true;
    }
  }
  std::vector<bool> wide = border;
  for (Cell c = 0; c < part.size(); ++c) {
    for (const Cells::Link& link : part.links[c]) {
      if (border[c]) wide[link.to] = true;
    }
  }
  return wide;
}

}  // namespace

std::vector<CellSet> ConnectedSets(const Cells& cells, const std::vector<bool>& side) {
  std::vector<CellSet> sets;
  std::vector<bool> seen(cells.size(), false);
  for (Cell c = 0; c < cells.size(); ++c) {
    if (seen[c]) continue;
    seen[c] = true;
    sets.push_back({c});
    CellSet& set = sets.back();
    for (std::size_t k = 0; k < set.size(); ++k) {
      for (const Cells::Link& link : cells.links[set[k]]) {
        if (seen[link.to] || side[link.to] != side[c]) continue;
        seen[link.to] = true;
        set.push_back(link.to);
      }
    }
    std::sort(set.begin(), set.end());
  }
  return sets;
}

double HandleLoops(const Cells& part, const std::vector<bool>& off) {
  if (ConnectedSets(part, off).size() != 2) return 1.0;
  const std::vector<bool> border = AtBorder(part, off);
  double loops = 0.0;
  for (const CellSet& set : ConnectedSets(part, border)) {
    // A border that ends at cells outside of the part is no loop.
    if (border[set.front()] &&
        std::none_of(set.begin(), set.end(), [&](Cell c) { return part.on_edge[c]; })) {
      loops += 1.0;
    }
  }
  return std::max(1.0, loops);
}

double Solidity(const Cells& part, const std::vector<bool>& in, bool side) {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double area = 0.0;
  for (Cell c = 0; c < part.size(); ++c) {
    if (in[c] != side) continue;
    center += part.area[c] * part.center[c];
    area += part.area[c];
  }
  center /= area;
  double volume = 0.0;
  for (Cell c = 0; c < part.size(); ++c) {
    if (in[c] != side) continue;
    volume += part.area[c] * part.normal[c].dot(part.center[c] - center);
  }
  return volume / std::pow(area, 1.5);
}

Split BestSplit(const Cells& part, const std::vector<std::vector<bool>>& candidates,
                const SplitOptions& options) {
  constexpr double kMaxLoops = 4.0;  // for a quick look; handles with more ends are rare
  Split best{std::numeric_limits<double>::infinity(), {}};
  double total = 0.0;
  for (const double area : part.area) total += area;
  for (const std::vector<bool>& candidate : candidates) {
    for (CellSet& piece : ConnectedSets(part, candidate)) {
      const double area = AreaOf(part, piece);
      const double smaller = std::min(area, total - area);
      if (!(smaller >= options.min_area && smaller > 0.0)) continue;
      double quality = BorderCost(part, piece, candidate) / std::sqrt(4.0 * core::kPi * smaller);
      if (quality >= kMaxLoops * best.quality) continue;
      const std::vector<bool> off = Members(part, piece);
      quality /= std::min(kMaxLoops, HandleLoops(part, off));
      if (quality >= best.quality) continue;
      const bool side = 2.0 * area <= total;
      if (Solidity(part, off, side) < options.solidity) continue;
      // A strip along a border that was cut before: the same crease, seen again from beside it.
      if (EdgeShare(part, off, side) > kStrip) continue;
      best = {quality, std::move(piece)};
    }
  }
  return best;
}

std::vector<CellSet> Divide(const Cells& part, const CellSet& off, double min_area) {
  std::vector<bool> side = Members(part, off);
  std::vector<CellSet> rest;
  for (CellSet& set : ConnectedSets(part, side)) {
    if (!side[set.front()]) rest.push_back(std::move(set));
  }
  const auto largest = std::max_element(
      rest.begin(), rest.end(),
      [&](const CellSet& a, const CellSet& b) { return AreaOf(part, a) < AreaOf(part, b); });
  for (auto set = rest.begin(); set != rest.end(); ++set) {
    if (set == largest || AreaOf(part, *set) >= min_area) continue;
    for (const Cell c : *set) side[c] = true;
  }
  return ConnectedSets(part, side);
}

}  // namespace rangegrasp::parts
