#include "parts/hierarchy/internal/best_split.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/units.h"

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

/// The connected pieces on both sides of a candidate.
struct SidePieces {
  std::vector<std::uint32_t> of_cell;
  std::vector<double> area;
  std::vector<double> cost;    ///< of the border
  std::vector<double> length;  ///< of the border
};

SidePieces PiecesOf(const Cells& part, const std::vector<bool>& candidate) {
  constexpr std::uint32_t kNoSplit = std::numeric_limits<std::uint32_t>::max();
  SidePieces pieces;
  pieces.of_cell.assign(part.size(), kNoSplit);
  std::vector<Cell> front;
  for (Cell first = 0; first < part.size(); ++first) {
    if (pieces.of_cell[first] != kNoSplit) continue;
    const auto piece = static_cast<std::uint32_t>(pieces.area.size());
    double area = 0.0;
    double cost = 0.0;
    double length = 0.0;
    pieces.of_cell[first] = piece;
    front.push_back(first);
    while (!front.empty()) {
      const Cell c = front.back();
      front.pop_back();
      area += part.area[c];
      for (const Cells::Link& link : part.links[c]) {
        if (candidate[link.to] != candidate[c]) {
          cost += link.cost;
          length += link.length;
        } else if (pieces.of_cell[link.to] == kNoSplit) {
          pieces.of_cell[link.to] = piece;
          front.push_back(link.to);
        }
      }
    }
    pieces.area.push_back(area);
    pieces.cost.push_back(cost);
    pieces.length.push_back(length);
  }
  return pieces;
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
  if (PiecesOf(part, off).area.size() != 2) return 1.0;
  const std::vector<bool> border = AtBorder(part, off);
  const SidePieces pieces = PiecesOf(part, border);
  std::vector<bool> loop(pieces.area.size(), true);
  for (Cell c = 0; c < part.size(); ++c) {
    // A border that ends at cells outside of the part is no loop.
    if (!border[c] || part.on_edge[c]) loop[pieces.of_cell[c]] = false;
  }
  return std::max(1.0, static_cast<double>(std::count(loop.begin(), loop.end(), true)));
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
    const SidePieces pieces = PiecesOf(part, candidate);
    for (std::uint32_t p = 0; p < pieces.area.size(); ++p) {
      const double area = pieces.area[p];
      const double smaller = std::min(area, total - area);
      if (!(smaller >= options.min_area && smaller > 0.0)) continue;
      if (pieces.cost[p] > options.max_flatness * pieces.length[p]) continue;
      double quality = pieces.cost[p] / std::sqrt(4.0 * base::kPi * smaller);
      if (quality >= kMaxLoops * best.quality) continue;
      std::vector<bool> off(part.size());
      for (Cell c = 0; c < part.size(); ++c) off[c] = pieces.of_cell[c] == p;
      quality /= std::min(kMaxLoops, HandleLoops(part, off));
      if (quality >= best.quality) continue;
      const bool side = 2.0 * area <= total;
      if (Solidity(part, off, side) < options.solidity) continue;
      // A strip along a border that was cut before: the same crease, seen again from beside it.
      if (EdgeShare(part, off, side) > kStrip) continue;
      best = {quality, {}};
      for (Cell c = 0; c < part.size(); ++c) {
        if (off[c]) best.off.push_back(c);
      }
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
