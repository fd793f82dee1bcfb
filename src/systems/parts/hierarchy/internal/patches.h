#pragma once

#include <cstdint>
#include <vector>

#include "parts/shape/face_frames.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {

/// A mesh in patches: the connected faces whose centers lie in the same cube of a grid.
struct Patches {
  std::vector<std::int32_t> of_face;
  geometry::Points center;  ///< mean over the patch's area
  geometry::Points normal;  ///< unit, or zero
  std::vector<double> area;

  std::size_t size() const { return area.size(); }
};
/// Patches are numbered by their first faces. O(n).
/// @param side  of the cubes, > 0.
Patches CutByGrid(const FaceGraph& faces, const FaceFrames& frames, double side);

}  // namespace rangegrasp::parts
