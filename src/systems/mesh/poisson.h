#pragma once

#include <optional>

#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// The closed surface whose gradient of inside and outside fits oriented points best (Poisson
/// reconstruction; Kazhdan, Bolitho and Hoppe 2006; CGAL's, by Delaunay refinement). Where there
/// are no points it closes smoothly. The same points give the same surface, but not the same
/// triangles: CGAL's refinement takes cells in the order of their addresses.
/// @param cloud      with outward unit normals, evenly spread; 100 points at least.
/// @param spacing_m  of its points: triangles stand off by 0.25 of it at most.
/// @return faces outward; nullopt if no surface fits.
/// @throws std::invalid_argument if points and normals are not as many, or too few.
std::optional<TriangleMesh> PoissonSurface(const PointCloud& cloud, double spacing_m);

}  // namespace rangegrasp::geometry
