#pragma once

#include <memory>
#include <span>

#include "geometry/ray_caster.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {

/// How much the surface bends across each edge, seen at a scale [rad; > 0 where it is concave]: the
/// curvature tensor of Cohen-Steiner and Morvan (2003) over the ball B of radius `scale` round the
/// edge, across its direction d: -sum_e beta(e) |e n B| w(e) (d . e)^2 / (2 scale), with the angle
/// beta of each edge e in B whose normal does not point away and its weight w = 2 (1 - distance /
/// scale). A long straight crease alone in the ball has its own dihedral angle. Parallel to
/// FaceGraph::neighbor. O(n log n) for a mesh of evenly large faces.
std::vector<double> EdgeBends(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                              double scale);

/// What cutting along an edge costs: its length times exp(-gain * bend) where it is concave and
/// 1 + gain / 4 * |bend| where it is convex. Parallel to FaceGraph::neighbor.
std::vector<double> BendCosts(const Shape& mesh, const FaceGraph& faces,
                              const std::vector<double>& bends, double gain);

class Sight;

/// A mesh in cells of faces that end at concave creases.
struct Cells {
  struct Border {
    double cost = 0.0;  ///< of cutting along it
    double length = 0.0;
  };
  Labels of_face;
  Indices begin;               ///< cells + 1
  Indices neighbor;            ///< of cell c those that touch it, ascending: [begin[c], begin[c+1])
  std::vector<Border> border;  ///< with each of these
  Points center;
  Points normal;  ///< unit, or zero
  std::vector<double> area;
  std::vector<std::uint8_t> on_edge;  ///< touches cells that were left out
  std::shared_ptr<Sight> sight;       ///< null: cells are not looked through
  Indices name;                       ///< of each cell: its number in `sight`

  std::uint32_t size() const { return static_cast<std::uint32_t>(area.size()); }
  std::span<const std::uint32_t> NeighborsOf(std::uint32_t c) const {
    return std::span(neighbor).subspan(begin[c], begin[c + 1] - begin[c]);
  }
};

/// Whether two cells see each other through the inside: of a weakly convex part most do. Whether
/// the line between their middles, a little below the surface, meets no face, is found out when it
/// is asked for first. O(log faces) a pair.
class Sight {
 public:
  Sight(const Shape& mesh, const FaceFrames& frames, const Cells& cells);
  /// All is known.
  explicit Sight(const std::vector<std::vector<bool>>& sees);

  using Pair = std::pair<std::uint32_t, std::uint32_t>;
  /// Of each pair of different cells, whether they see each other: 0 or 1.
  void Look(std::span<const Pair> pairs, std::vector<std::uint8_t>& sees);
  /// Of each cell, its place in an order of which any beginning is spread over the surface.
  const Indices& rank() const { return rank_; }

 private:
  /// Of a pair a < b; of (0, b), how many pairs there are below b.
  static std::size_t PlaceOf(std::size_t a, std::size_t b) { return b * (b - 1) / 2 + a; }
  static constexpr std::uint8_t kUnknown = 2;

  std::unique_ptr<const geometry::RayCaster> caster_;
  Points below_;  ///< where cells look from
  Indices rank_;
  std::vector<std::uint8_t> sees_;  ///< of pairs: 0, 1 or unknown
  std::vector<geometry::Ray> rays_;
  std::vector<std::pair<std::size_t, std::size_t>> asked_;  ///< places in sees_ and in the answer
  std::vector<std::uint8_t> blocked_;
};

/// About `count` cells: one round a seed in each cube of a grid, faces to the nearest. A way across
/// faces is as long as it is, times 1 + crease * the concave bend it crosses. Seeds move to their
/// cells' middles, and faces choose again. Every connected piece has a cell.
/// @param bends, costs  of the graph's edges, as its neighbors.
Cells BuildCells(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                 const std::vector<double>& bends, const std::vector<double>& costs, int count,
                 double crease);

/// Some cells as cells of their own, in the order given; of_face stays empty.
Cells Subset(const Cells& cells, const Indices& some);

}  // namespace rangegrasp::parts
