#pragma once

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

/// A mesh in cells of faces that end at concave creases.
struct Cells {
  struct Link {
    std::uint32_t to;
    double cost;    ///< of cutting along the border
    double length;  ///< of the border
  };
  Labels of_face;
  std::vector<std::vector<Link>> links;  ///< to touching cells, ascending
  Points center;
  Points normal;  ///< unit, or zero
  std::vector<double> area;
  std::vector<bool> on_edge;  ///< touches cells that were left out
  /// Whether two cells see each other through the inside: of a weakly convex part most do.
  std::vector<std::vector<bool>> sees;

  std::uint32_t size() const { return static_cast<std::uint32_t>(area.size()); }
};
/// About `count` cells: one round a seed in each cube of a grid, faces to the nearest. A way across
/// faces is as long as it is, times 1 + crease * the concave bend it crosses. Seeds move to their
/// cells' middles, and faces choose again. Every connected piece has a cell.
/// @param bends, costs  of the graph's edges, as its neighbors.
Cells BuildCells(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                 const std::vector<double>& bends, const std::vector<double>& costs, int count,
                 double crease);

/// Fills in which cells see each other: whether the line between their middles, a little below the
/// surface, meets no face. O(cells^2 log faces).
void LookThrough(const Shape& mesh, const FaceFrames& frames, Cells& cells);

/// Some cells as cells of their own, in the order given; of_face stays empty.
Cells Subset(const Cells& cells, const Indices& some);

}  // namespace rangegrasp::parts
