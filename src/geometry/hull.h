#pragma once

#include "geometry/mesh.h"

namespace rangegrasp::geometry {

/// The convex hull (eq. 5.1) as a closed triangle mesh, faces outward; empty if the points are
/// (nearly) in one plane. Vertices are sorted by coordinates and triangles by vertices: the same
/// points give the same bytes.
TriangleMesh ConvexHull(PointSpan points);

}  // namespace rangegrasp::geometry
