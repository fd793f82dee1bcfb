#include "parts/hierarchy/internal/cuts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <unordered_set>
#include <utility>

#include "base/units.h"
#include "geometry/graph.h"
#include "parts/mirror/internal/spherical_mirror.h"

namespace rangegrasp::parts {
namespace {

using geometry::kFar;
using Cell = std::uint32_t;

// ---- the best split ----

/// A side is a strip if more than this fraction of its area is in cells at the part's own edge.
constexpr double kStrip = 0.5;

/// Maximum number of cells that look across a cut from each side: enough for a fraction of pairs.
constexpr std::size_t kMaxLookers = 64;
/// Pairs are compared with others at the same distance, in this many bins up to this multiple of
/// the reach. Two cells are at most twice the reach plus the width of the cut apart.
constexpr std::size_t kFarBins = 8;
constexpr double kFarthest = 2.5;
/// Number of pairs on one side that a bin needs for the comparison.
constexpr int kMinPairs = 8;
/// If a smaller fraction of the pairs on one side see each other, it is not a weakly convex part
/// but a wall, about which visibility says nothing.
constexpr double kMinConvex = 0.5;
/// Lower limit of what is seen across a cut: a part that sees nothing of the rest is no better.
constexpr double kMinSeen = 0.1;

/// Sums over some cells: everything by which a side is judged before visibility is tested.
struct Sums {
  double area = 0.0, at_edge = 0.0;  ///< at_edge: in cells at the part's own edge
  Eigen::Vector3d moment = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
  double flux = 0.0;

  void Add(const Cells& part, Cell c) {
    const double a = part.area[c];
    area += a;
    if (part.on_edge[c]) at_edge += a;
    moment += a * part.center[c];
    normal += a * part.normal[c];
    flux += a * part.normal[c].dot(part.center[c]);
  }
  Sums Without(const Sums& other) const {
    return {area - other.area, at_edge - other.at_edge, moment - other.moment,
            normal - other.normal, flux - other.flux};
  }
  double Solidity() const { return (flux - normal.dot(moment) / area) / std::pow(area, 1.5); }
};

/// A connected piece on one side of a candidate.
struct SidePiece {
  Sums sums;
  double cost = 0.0, length = 0.0;  ///< of the border
  std::uint64_t name = 0;           ///< equal for the same cells
};

/// Hash of a cell; sums of hashes are equal only for the same cells (splitmix64).
std::uint64_t NameOf(Cell c) {
  std::uint64_t z = (c + 1) * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/// The connected pieces on both sides.
/// @param of_cell  output, the piece of each cell
std::vector<SidePiece> SidePiecesOf(const Cells& part, const Sides& side, Labels& of_cell) {
  of_cell.assign(part.size(), -1);
  std::vector<SidePiece> pieces;
  Indices front;
  for (Cell first = 0; first < part.size(); ++first) {
    if (of_cell[first] >= 0) continue;
    const auto number = static_cast<std::int32_t>(pieces.size());
    SidePiece& piece = pieces.emplace_back();
    of_cell[first] = number;
    front.push_back(first);
    while (!front.empty()) {
      const Cell c = front.back();
      front.pop_back();
      piece.sums.Add(part, c);
      piece.name += NameOf(c);
      for (std::uint32_t k = part.begin[c]; k < part.begin[c + 1]; ++k) {
        const Cell next = part.neighbor[k];
        if (side[next] != side[c]) {
          piece.cost += part.border[k].cost;
          piece.length += part.border[k].length;
        } else if (of_cell[next] < 0) {
          of_cell[next] = number;
          front.push_back(next);
        }
      }
    }
  }
  return pieces;
}

/// One of the pieces of a candidate as a side.
Sides SideOf(const Cells& part, const Sides& candidate, std::int32_t piece) {
  Labels of_cell;
  SidePiecesOf(part, candidate, of_cell);
  Sides off(part.size());
  for (Cell c = 0; c < part.size(); ++c) off[c] = of_cell[c] == piece;
  return off;
}

Indices CellsOn(const Sides& side) {
  return geometry::PositionsWhere(side, [](std::uint8_t in) { return in != 0; });
}

/// Cells along the border, on both of its sides.
Sides BorderOf(const Cells& part, const Sides& off) {
  Sides border(part.size(), 0);
  for (Cell c = 0; c < part.size(); ++c) {
    for (const Cell next : part.NeighborsOf(c)) border[c] |= off[next] != off[c];
  }
  return border;
}

/// The cells within reach of a border on both of its sides, at most 64 on each.
std::array<Indices, 2> Lookers(const Cells& part, const Sides& off, double reach) {
  std::vector<double> distance(part.size(), kFar);
  const auto expand = [&](Cell c, double d, const auto& lower) {
    for (const Cell next : part.NeighborsOf(c)) {
      lower(next, d + (part.center[c] - part.center[next]).norm());
    }
  };
  geometry::LowerDistances(CellsOn(BorderOf(part, off)), distance, expand, reach);
  std::array<Indices, 2> sides;
  for (Cell c = 0; c < part.size(); ++c) {
    if (distance[c] <= reach) sides[off[c]].push_back(c);
  }
  for (Indices& side : sides) {
    if (side.size() <= kMaxLookers) continue;
    // Takes the same cells for one cut after the other, so that their visibility is tested once.
    const auto rank = [&](Cell c) { return part.sight->rank()[part.name[c]]; };
    std::ranges::nth_element(side, side.begin() + kMaxLookers, {}, rank);
    side.resize(kMaxLookers);
  }
  return sides;
}

/// Pairs of cells and their distances.
class Pairs {
 public:
  using Counts = std::array<int, kFarBins>;

  /// @param farthest  distance from which pairs belong to the last bin
  Pairs(const Cells& part, double farthest)
      : part_(part), squares_(kFarBins * kFarBins / (farthest * farthest)) {}

  void Add(Cell a, std::span<const Cell> others) {
    for (const Cell b : others) {
      names_.emplace_back(part_.name[a], part_.name[b]);
      const double squares = squares_ * (part_.center[a] - part_.center[b]).squaredNorm();
      bins_.push_back(static_cast<std::uint8_t>(std::sqrt(std::floor(std::min(squares, kLast)))));
      ++counts_[bins_.back()];
    }
  }
  /// Counts those of the next `count` pairs that see each other in their bins.
  void Look(std::size_t count, Counts& seen) {
    part_.sight->Look(std::span(names_).subspan(looked_, count), sees_);
    for (std::size_t k = 0; k < count; ++k) seen[bins_[looked_ + k]] += sees_[k];
    looked_ += count;
  }
  std::size_t size() const { return names_.size(); }
  const Counts& counts() const { return counts_; }

 private:
  static constexpr double kLast = kFarBins * kFarBins - 1;
  const Cells& part_;
  double squares_;
  std::vector<Sight::Pair> names_;
  std::vector<std::uint8_t> bins_, sees_;
  Counts counts_{};
  std::size_t looked_ = 0;
};

// ---- candidates ----

/// Picks `count` points, each as far as possible from those before; the first one is the farthest
/// from the middle.
Indices FarApart(const Points& points, std::size_t count) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean += p / static_cast<double>(points.size());
  std::vector<double> distance(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) distance[i] = (points[i] - mean).squaredNorm();
  Indices chosen;
  while (chosen.size() < std::min(count, points.size())) {
    const auto next = std::ranges::max_element(distance) - distance.begin();
    if (chosen.empty()) std::ranges::fill(distance, kFar);
    chosen.push_back(static_cast<std::uint32_t>(next));
    for (std::size_t i = 0; i < points.size(); ++i) {
      distance[i] = std::min(distance[i], (points[i] - points[next]).squaredNorm());
    }
  }
  return chosen;
}

/// Directions spread evenly over the sphere: a golden-angle spiral.
Eigen::Matrix<double, Eigen::Dynamic, 3> Directions(int count) {
  const double golden = base::kPi * (3.0 - std::sqrt(5.0));
  Eigen::Matrix<double, Eigen::Dynamic, 3> directions(count, 3);
  for (int k = 0; k < count; ++k) {
    const double z = 1.0 - (2.0 * k + 1.0) / count;
    const double r = std::sqrt(1.0 - z * z);
    directions.row(k) << r * std::cos(golden * k), r * std::sin(golden * k), z;
  }
  return directions;
}

/// Depth of each mirrored point below the hull of all: the least distance to the tangent planes of
/// the hull in many directions.
std::vector<double> MirrorDepths(const Points& points, const Eigen::Vector3d& center) {
  // 10 degrees apart: finer steps change no order that matters.
  static const Eigen::Matrix<double, Eigen::Dynamic, 3> directions = Directions(400);
  const Points mirrored = MirrorOut(points, SphereRound(center, points));
  const auto heights = [](const Eigen::Vector3d& p) {
    return directions.col(0) * p.x() + directions.col(1) * p.y() + directions.col(2) * p.z();
  };
  Eigen::VectorXd levels = heights(mirrored.front());
  for (const Eigen::Vector3d& p : mirrored) levels = levels.cwiseMax(heights(p));
  std::vector<double> depth;
  for (const Eigen::Vector3d& p : mirrored) depth.push_back((levels - heights(p)).minCoeff());
  return depth;
}

/// All cells reachable from `start`, lowest depth (best seen) first.
Indices GrowthOrder(const Cells& cells, const std::vector<double>& depth, std::uint32_t start) {
  std::vector<double> reached(cells.size(), kFar);
  Indices order;
  const auto expand = [&](std::uint32_t c, double, const auto& reach) {
    order.push_back(c);
    for (const Cell next : cells.NeighborsOf(c)) reach(next, depth[next]);
  };
  geometry::LowerDistances({{start}}, reached, expand);
  return order;
}

/// The cheapest set of cells that contains those before `begin` in the order and none from `end`
/// on.
/// @param place  of each cell in the order; larger for cells that are not in it
Sides CutBetween(const Cells& cells, const Indices& order, const Indices& place,
                 std::uint32_t begin, std::uint32_t end) {
  const auto node = [&](Cell c) {
    return place[c] < begin ? kSource : place[c] >= end ? kSink : place[c] - begin + kSink + 1;
  };
  std::vector<CutLink> links;
  for (const Cell c : std::span(order).first(end)) {
    for (std::uint32_t k = cells.begin[c]; k < cells.begin[c + 1]; ++k) {
      const Cell next = cells.neighbor[k];
      // Each link is added from its later cell, unless that is in the sink.
      if (place[next] < place[c] ? place[c] < begin : place[next] < end) continue;
      links.push_back({node(c), node(next), cells.border[k].cost});
    }
  }
  const std::vector<bool> with_source = MinCut(kSink + 1 + end - begin, links);
  Sides within(cells.size());
  for (Cell c = 0; c < cells.size(); ++c) within[c] = with_source[node(c)];
  return within;
}

/// Area fraction of the first core: just below the smallest part.
constexpr double kFirstCore = 0.004;
/// Area fraction of the last core; the outside is to be a part.
constexpr double kLastCore = 0.7;
/// The cut lies in a band between a core and one that is this many times as large. A wider band
/// finds more distant necks and takes more time.
constexpr double kBand = 3.0;

void AddCores(const Cells& cells, const Indices& order, int levels, std::set<Sides>& candidates) {
  Indices place(cells.size(), kNoNode);
  for (std::uint32_t k = 0; k < order.size(); ++k) place[order[k]] = k;
  std::vector<double> before;  // area of the cells before, in this order
  double total = 0.0;
  for (const std::uint32_t c : order) {
    before.push_back(total);
    total += cells.area[c];
  }
  const auto first_at = [&](double area) {
    return static_cast<std::uint32_t>(std::ranges::lower_bound(before, area) - before.begin());
  };
  const double growth = std::pow(kLastCore / kFirstCore, 1.0 / std::max(1, levels - 1));
  double share = kFirstCore;
  for (int level = 0; level < levels; ++level, share *= growth) {
    const std::uint32_t begin = std::max(1u, first_at(share * total));
    // At least half of the area outside of a large core stays in the rest.
    const double band_end = std::min(kBand * share, 0.5 + 0.5 * share);
    const std::uint32_t end =
        std::min(first_at(band_end * total), static_cast<std::uint32_t>(order.size() - 1));
    if (end <= begin) continue;
    candidates.insert(CutBetween(cells, order, place, begin, end));
  }
}

// ---- borders ----

using Pair = std::pair<std::int32_t, std::int32_t>;

/// A minimum cut through the faces of two parts within `width` of the border between them. The ring
/// of faces around these keeps its labels.
void MoveBorder(const FaceGraph& faces, const FaceFrames& frames, const std::vector<double>& costs,
                const Pair& pair, double width, Labels& label) {
  const auto in_pair = [&](std::uint32_t f) {
    return label[f] == pair.first || label[f] == pair.second;
  };
  Indices at_border;
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t) {
    if (label[g] != label[f] && in_pair(f) && in_pair(g)) at_border.push_back(f);
  });
  std::vector<double> distance(label.size(), kFar);
  const auto expand = [&](std::uint32_t f, double d, const auto& reach) {
    for (std::uint32_t k = faces.begin[f]; k < faces.begin[f + 1]; ++k) {
      const std::uint32_t g = faces.neighbor[k];
      if (in_pair(g)) reach(g, d + (frames.center[f] - frames.center[g]).norm());
    }
  };
  geometry::LowerDistances(at_border, distance, expand, width);
  std::uint32_t nodes = 2;
  Indices node(label.size(), kNoNode);
  std::set<std::int32_t> keep;
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    if (distance[f] == kFar) continue;
    node[f] = distance[f] <= width ? nodes++ : label[f] == pair.first ? kSource : kSink;
    if (node[f] <= kSink) keep.insert(label[f]);
  }
  // Without a ring in both parts there is nothing to cut between, and one part would vanish.
  if (keep.size() == 2) CutFaces(faces, costs, nodes, node, pair.first, pair.second, label);
}

}  // namespace

std::vector<Indices> ConnectedSets(const Cells& cells, const Sides& side) {
  Labels of_cell;
  std::vector<Indices> sets(SidePiecesOf(cells, side, of_cell).size());
  for (Cell c = 0; c < cells.size(); ++c) sets[of_cell[c]].push_back(c);
  return sets;
}

double HandleLoops(const Cells& part, const Sides& off) {
  Labels of_cell;
  if (SidePiecesOf(part, off, of_cell).size() != 2) return 1.0;
  const Sides border = BorderOf(part, off);
  // Consecutive cells along a border need not share an edge; with those that touch them, they do.
  Sides wide = border;
  for (Cell c = 0; c < part.size(); ++c) {
    if (!border[c]) continue;
    for (const Cell next : part.NeighborsOf(c)) wide[next] = 1;
  }
  std::vector<bool> loop(SidePiecesOf(part, wide, of_cell).size(), true);
  for (Cell c = 0; c < part.size(); ++c) {
    // A border that ends at cells outside of the part is not closed.
    if (!wide[c] || part.on_edge[c]) loop[of_cell[c]] = false;
  }
  return std::max(1.0, static_cast<double>(std::ranges::count(loop, true)));
}

double Solidity(const Cells& part, const Sides& in) {
  Sums sums;
  for (Cell c = 0; c < part.size(); ++c) {
    if (in[c]) sums.Add(part, c);
  }
  return sums.Solidity();
}

std::optional<double> SeenAcross(const Cells& part, const Sides& off, double reach, double limit) {
  const std::array<Indices, 2> sides = Lookers(part, off, reach);
  Pairs within(part, kFarthest * reach), across = within;
  for (const Indices& side : sides) {
    for (std::size_t i = 0; i < side.size(); ++i) within.Add(side[i], std::span(side).first(i));
  }
  for (const Cell a : sides[0]) across.Add(a, sides[1]);
  const auto sum = [&](const auto& value) {
    double total = 0.0;
    for (std::size_t k = 0; k < kFarBins; ++k) {
      if (within.counts()[k] >= kMinPairs) total += value(k);
    }
    return total;
  };
  const double pairs = sum([&](std::size_t k) { return across.counts()[k]; });
  Pairs::Counts seen_within{}, seen_across{};
  double seen = 0.0;
  for (std::size_t i = 0; i < sides[0].size(); ++i) {
    across.Look(sides[1].size(), seen_across);
    seen = sum([&](std::size_t k) { return seen_across[k]; });
    // At most, all pairs are expected to see each other.
    if (seen > (1.0 + 1e-9) * limit * pairs) return std::nullopt;
  }
  within.Look(within.size(), seen_within);
  const double expected = sum([&](std::size_t k) {
    return static_cast<double>(seen_within[k]) / within.counts()[k] * across.counts()[k];
  });
  if (!(expected > kMinConvex * pairs)) return 1.0;
  return std::clamp(seen / expected, kMinSeen, 1.0);
}

CutOff BestSplit(const Cells& part, const std::vector<Sides>& candidates, double min_area,
                 const HierarchyOptions& options) {
  constexpr double kMaxLoops = 4.0;  // for a quick test; handles with more ends are rare
  Sums all;
  std::uint64_t all_name = 0;
  for (Cell c = 0; c < part.size(); ++c) {
    all.Add(part, c);
    all_name += NameOf(c);
  }
  struct Try {
    double quality, smaller, flatness;
    std::size_t candidate;
    std::int32_t piece;
  };
  std::vector<Try> tries;
  std::unordered_set<std::uint64_t> known;
  Labels of_cell;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    const std::vector<SidePiece> pieces = SidePiecesOf(part, candidates[k], of_cell);
    // Two pieces are the two sides of the same cut.
    for (std::int32_t p = pieces.size() == 2 ? 1 : 0; p < std::ssize(pieces); ++p) {
      const auto& [sums, cost, length, name] = pieces[p];
      const Sums side = 2.0 * sums.area <= all.area ? sums : all.Without(sums);
      if (!(side.area >= min_area && side.area > 0.0)) continue;
      if (side.Solidity() < options.solidity) continue;
      // A strip along an earlier cut has the same crease, seen again from next to it.
      if (side.at_edge > kStrip * side.area) continue;
      // Many candidates contain the same piece, or everything but that piece.
      if (!known.insert(std::min(name, all_name - name)).second) continue;
      tries.push_back(
          {cost / std::sqrt(4.0 * base::kPi * side.area), side.area, cost / length, k, p});
    }
  }
  std::ranges::stable_sort(tries, {}, &Try::quality);
  CutOff best{std::numeric_limits<double>::infinity(), {}};
  for (const Try& one : tries) {
    if (one.quality * kMinSeen >= kMaxLoops * best.quality) break;
    const Sides off = SideOf(part, candidates[one.candidate], one.piece);
    double quality = one.quality / std::min(kMaxLoops, HandleLoops(part, off));
    if (quality * kMinSeen >= best.quality) continue;
    double seen = 1.0;
    if (part.sight) {
      const double limit = std::min(options.max_flatness / one.flatness, best.quality / quality);
      const auto found = SeenAcross(part, off, options.sight * std::sqrt(one.smaller), limit);
      if (!found) continue;
      seen = *found;
    }
    // A border with a flatness of 1 is not concave: a rod is not cut, however long it is.
    if (one.flatness * seen > options.max_flatness) continue;
    quality *= seen;
    if (quality < best.quality) best = {quality, CellsOn(off)};
  }
  return best;
}

std::vector<Indices> Divide(const Cells& part, const Indices& off, double min_area) {
  Sides side(part.size(), 0);
  for (const Cell c : off) side[c] = 1;
  std::vector<Indices> rest = ConnectedSets(part, side);
  std::erase_if(rest, [&](const Indices& set) { return side[set.front()]; });
  const auto area_of = [&](const Indices& set) {
    double area = 0.0;
    for (const Cell c : set) area += part.area[c];
    return area;
  };
  const auto largest = std::ranges::max_element(rest, {}, area_of);
  for (const Indices& set : rest) {
    if (&set == &*largest || area_of(set) >= min_area) continue;
    for (const Cell c : set) side[c] = 1;
  }
  return ConnectedSets(part, side);
}

Eigen::Vector3d InnerCenter(const Cells& cells, std::uint32_t c) {
  // Minimum sine of the angle below the surface for other cells. The neighbors of the cell, which
  // noise lifts or lowers, would otherwise give balls of any size.
  constexpr double kMinSlope = 0.3;
  const Eigen::Vector3d& p = cells.center[c];
  const Eigen::Vector3d& n = cells.normal[c];
  // The ball's radius is squared / (2 below). Products avoid a root and a division per cell.
  double squared = 1.0, below = 0.0;
  for (Cell other = 0; other < cells.size(); ++other) {
    const Eigen::Vector3d to = p - cells.center[other];
    const double other_below = n.dot(to);
    const double other_squared = to.squaredNorm();
    if (other_below <= 0.0 || other_below * other_below <= kMinSlope * kMinSlope * other_squared) {
      continue;
    }
    if (other_squared * below < squared * other_below) {
      squared = other_squared;
      below = other_below;
    }
  }
  return below > 0.0 ? Eigen::Vector3d(p - squared / (2.0 * below) * n) : p;
}

std::vector<Sides> MirrorCandidates(const Cells& cells, int centers, int levels) {
  std::set<Sides> candidates;
  std::vector<double> radius(cells.size());
  Points center(cells.size());
  for (std::uint32_t c = 0; c < cells.size(); ++c) {
    center[c] = InnerCenter(cells, c);
    radius[c] = (center[c] - cells.center[c]).norm();
  }
  const auto grow = [&](const std::vector<double>& key, std::uint32_t start) {
    const Indices order = GrowthOrder(cells, key, start);
    if (order.size() > 1) AddCores(cells, order, levels, candidates);
  };
  for (const std::uint32_t c : FarApart(cells.center, centers)) {
    grow(MirrorDepths(cells.center, center[c]), c);
    grow(radius, c);
  }
  return {candidates.begin(), candidates.end()};
}

void MoveBorders(const FaceGraph& faces, const FaceFrames& frames, const std::vector<double>& costs,
                 double width, Labels& label) {
  std::set<Pair> touching;
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t) {
    if (label[f] < label[g]) touching.insert({label[f], label[g]});
  });
  for (const Pair& pair : touching) MoveBorder(faces, frames, costs, pair, width, label);
}

}  // namespace rangegrasp::parts
