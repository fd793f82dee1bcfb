#pragma once

#include <cstdint>
#include <vector>

#include "parts/shape/clean_shape.h"

namespace rangegrasp::parts {

/// A mesh as it would be whatever way it lay and was written down: its surface has area 1 and its
/// center of gravity at the origin, its axes of inertia are x, y, z by falling extent, pointing
/// where the surface is skewed to, and vertices and faces stand in the order of their coordinates.
///
/// Bytes are the same for any order of vertices and faces. For any turn, shift and scale they are
/// the same up to rounding, which is cut off; only of a shape whose extents or skews are equal to
/// the last digits, one that a turn or mirroring maps onto itself, the axes may change places.
/// Faces cut in smaller ones do not move the axes, which are of the surface, not of its vertices.
struct CanonicalMesh {
  Shape mesh;
  std::vector<std::uint32_t> origin;  ///< of each face: its number in the input
};
/// O(n log n)
CanonicalMesh MakeCanonical(const Shape& mesh);

/// The same for a cloud, each of whose points counts as much as the others: its middle is the
/// origin, the mean square distance from it 1. O(n log n)
struct CanonicalCloud {
  geometry::Points points;
  std::vector<std::uint32_t> origin;  ///< of each point: its number in the input
};
CanonicalCloud MakeCanonicalCloud(const geometry::Points& points);

}  // namespace rangegrasp::parts
