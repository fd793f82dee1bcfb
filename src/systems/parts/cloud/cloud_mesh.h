#pragma once

#include "parts/shape/shape.h"

namespace rangegrasp::parts {

/// Triangles through evenly spread points of a surface, turned alike where they touch: the
/// advancing front of Cohen-Steiner and Da (2004; CGAL). Gaps wider than max_edge stay open.
/// Depends on the points and their order alone: ties go by numbers, not by addresses as CGAL's own.
std::vector<Face> AdvancingFront(const geometry::Points& points, double max_edge);

/// A mesh of the surface that a cloud samples.
struct CloudMesh {
  Shape mesh;             ///< in a frame and a unit of its own
  Indices face_of_point;  ///< the nearest face, one a point
};
/// The cloud is turned, scaled and sorted to a canonical form. An advancing front makes triangles
/// of the points of its surface, turned outwards; pieces of less than 0.5 % of the area are left
/// out. What the cloud does not show, as the far side of a single view, stays open. Where noise
/// tears thin limbs and walls to shreds, and more than one side was seen, the mesh is wrapped
/// (geometry::AlphaWrap): closed, a little outside of the points. Depends on
/// neither the order of the points nor on pose and scale, but for rounding. O(n log n); 100,000
/// points about a second.
/// @return without faces, if the points lie too far apart or too few of them are no strays.
CloudMesh MeshOfCloud(const geometry::Points& points);

}  // namespace rangegrasp::parts
