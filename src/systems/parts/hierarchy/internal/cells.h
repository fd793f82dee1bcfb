#pragma once

#include <memory>
#include <span>

#include "geometry/ray_caster.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {

/// How much the surface bends across each edge at a scale [rad; > 0 where it is concave]. It is the
/// curvature tensor of Cohen-Steiner and Morvan (2003) over the ball B of radius `scale` around the
/// edge, across its direction d: -sum_e beta(e) |e n B| w(e) (d . e)^2 / (2 scale). beta is the
/// angle of each edge e in B whose normal does not point away; its weight is w = 2 (1 - distance /
/// scale). A single long straight crease in the ball gives its own dihedral angle. Parallel to
/// FaceGraph::neighbor. O(n log n) for a mesh of evenly sized faces.
std::vector<double> EdgeBends(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                              double scale);

/// Cost of cutting along each edge: its length times exp(-gain * bend) where it is concave and 1 +
/// gain / 4 * |bend| where it is convex. Parallel to FaceGraph::neighbor.
std::vector<double> BendCosts(const Shape& mesh, const FaceGraph& faces,
                              const std::vector<double>& bends, double gain);

class Sight;

/// A mesh divided into cells of faces that end at concave creases.
struct Cells {
  struct Border {
    double cost = 0.0;  ///< cost of cutting along it
    double length = 0.0;
  };
  Labels of_face;
  Indices begin;               ///< size: cells + 1
  Indices neighbor;            ///< neighbors of cell c, ascending: [begin[c], begin[c+1])
  std::vector<Border> border;  ///< border with each neighbor
  Points center;
  Points normal;  ///< unit, or zero
  std::vector<double> area;
  std::vector<std::uint8_t> on_edge;  ///< 1: the cell touches cells that were left out
  std::shared_ptr<Sight> sight;       ///< null: visibility between cells is not used
  Indices name;                       ///< per cell: its number in `sight`

  std::uint32_t size() const { return static_cast<std::uint32_t>(area.size()); }
  std::span<const std::uint32_t> NeighborsOf(std::uint32_t c) const {
    return std::span(neighbor).subspan(begin[c], begin[c + 1] - begin[c]);
  }
};

/// Visibility between cells through the inside; in a weakly convex part most cells see each other.
/// Two cells see each other if the line between their middles, slightly below the surface, meets no
/// face. This is computed when it is first needed. O(log faces) per pair.
class Sight {
 public:
  Sight(const Shape& mesh, const FaceFrames& frames, const Cells& cells);
  /// All visibilities are given.
  explicit Sight(const std::vector<std::vector<bool>>& sees);

  using Pair = std::pair<std::uint32_t, std::uint32_t>;
  /// For each pair of different cells: 1 if they see each other, otherwise 0.
  void Look(std::span<const Pair> pairs, std::vector<std::uint8_t>& sees);
  /// Rank of each cell in an order of which every prefix is spread over the surface.
  const Indices& rank() const { return rank_; }

 private:
  /// Index of a pair a < b in sees_; for (0, b) the number of pairs below b.
  static std::size_t PlaceOf(std::size_t a, std::size_t b) { return b * (b - 1) / 2 + a; }
  static constexpr std::uint8_t kUnknown = 2;

  std::unique_ptr<const geometry::RayCaster> caster_;
  Points below_;  ///< viewpoint of each cell
  Indices rank_;
  std::vector<std::uint8_t> sees_;  ///< per pair: 0, 1 or unknown
  std::vector<geometry::Ray> rays_;
  std::vector<std::pair<std::size_t, std::size_t>> asked_;  ///< indices in sees_ and in the answer
  std::vector<std::uint8_t> blocked_;
};

/// Divides a mesh into about `count` cells around seeds, one in each cube of a grid; each face goes
/// to the nearest seed. The length of a path over faces is multiplied by 1 + crease * the concave
/// bend it crosses. Seeds then move to the middles of their cells, and faces are reassigned. Every
/// connected piece has a cell.
/// @param bends, costs  per edge of the graph, parallel to its neighbors
Cells BuildCells(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                 const std::vector<double>& bends, const std::vector<double>& costs, int count,
                 double crease);

/// A subset of the cells, renumbered in the given order; of_face stays empty.
Cells Subset(const Cells& cells, const Indices& some);

}  // namespace rangegrasp::parts
