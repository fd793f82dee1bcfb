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
