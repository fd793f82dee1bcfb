#pragma once

#include <cstdint>
#include <vector>

#include "parts/shape/face_frames.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {

/// A mesh in cells of faces that end at concave creases.
struct Cells {
  struct Link {
    std::uint32_t to;
    double cost;    ///< of cutting along the border
    double length;  ///< of the border
  };
  std::vector<std::int32_t> of_face;
  std::vector<std::vector<Link>> links;  ///< to touching cells, ascending
  geometry::Points center;
  geometry::Points normal;  ///< unit, or zero
  std::vector<double> area;
  std::vector<bool> on_edge;  ///< touches cells that were left out

  std::uint32_t size() const { return static_cast<std::uint32_t>(area.size()); }
};
/// About `count` cells: one round a seed in each cube of a grid, faces to the nearest. A way across
/// faces is as long as it is, times 1 + crease * the concave bend it crosses. Seeds move to their
/// cells' middles, and faces choose again. Every connected piece has a cell.
/// @param bends, costs  of the graph's edges, as its neighbors.
Cells BuildCells(const Shape& mesh, const FaceGraph& faces, const FaceFrames& frames,
                 const std::vector<double>& bends, const std::vector<double>& costs, int count,
                 double crease);

/// Some cells as cells of their own, in the order given; of_face stays empty.
Cells Subset(const Cells& cells, const std::vector<std::uint32_t>& some);

}  // namespace rangegrasp::parts
