#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "parts/shape.h"

namespace rangegrasp::parts {

/// Faces of a mesh with what cutting it needs.
struct FaceFrames {
  geometry::Points center;
  geometry::Points normal;
  std::vector<double> area;
  double total_area = 0.0;
};
FaceFrames BuildFaceFrames(const Shape& mesh);

/// How much the surface bends across each edge, seen at a scale [rad; > 0 where it is concave]: the
/// curvature tensor of Cohen-Steiner and Morvan (2003) over the ball B of radius `scale` round the
/// edge, across its direction d: -sum_e beta(e) |e n B| w(e) (d . e)^2 / (2 scale), with the angle
/// beta of each edge e in B whose normal does not point away and its weight w = 2 (1 - distance /
/// scale). A long straight crease alone in the ball has its own dihedral angle. Parallel to
/// FaceGraph::neighbor. Where the mesh has more than 100,000 edges, as many, evenly taken, stand
/// for all. O(n log n) for a mesh of evenly large faces.
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
    double cost;
  };
  std::vector<std::int32_t> of_face;
  std::vector<std::vector<Link>> links;  ///< to touching cells, ascending; cost of the border
  geometry::Points center;
  geometry::Points normal;  ///< unit, or zero
  std::vector<double> area;
  std::vector<bool> on_edge;  ///< touches cells that were left out

  std::uint32_t size() const { return static_cast<std::uint32_t>(area.size()); }
};
/// `count` seeds as far from each other as can be, faces to the nearest: a way across faces is as
/// long as it is, times 1 + crease * the concave bend it crosses. Seeds come in the order they were
/// taken, so that the first of them lie far apart. Every connected piece has a cell.
Cells BuildCells(const FaceGraph& faces, const FaceFrames& frames, const std::vector<double>& bends,
                 const std::vector<double>& costs, int count, double crease);

/// Some cells as cells of their own, in the order given; of_face stays empty.
Cells Subset(const Cells& cells, const std::vector<std::uint32_t>& some);

}  // namespace rangegrasp::parts
