#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// Holes up to this share of the mesh's diagonal are closed: those that scanners and exporters
/// leave. A larger hole may be the mouth of a cup whose wall has no thickness.
inline constexpr double kMaxHole = 0.2;

/// A mesh that bounds a solid: closed, each edge between two triangles, no intersecting triangles,
/// faces outward.
struct Repaired {
  TriangleMesh mesh;
  std::vector<std::string> done;   ///< defects and their repair, one sentence each
  bool turned_inside_out = false;  ///< the faces of the given mesh pointed inward
};

/// Merges equal vertices, removes triangles without area, makes orientations consistent, stitches
/// borders, closes small holes, turns faces outward (CGAL). The same mesh gives the same bytes.
/// @param mesh  in any unit; all coordinates finite.
/// @param max_hole  1: every hole is closed
/// @throws base::InputError with the reason if the repair fails: a large hole, no volume.
Repaired RepairMesh(const TriangleMesh& mesh, double max_hole = kMaxHole);

/// A closed surface around a mesh: CGAL's alpha wrap (Portaneri et al. 2022). It bridges gaps and
/// gives thickness to sheets. Its faces grow with `gap`. The same mesh gives the same bytes.
/// @param gap     > 0; radius of balls that do not fit through the bridged gaps
/// @param offset  > 0; distance from the mesh
TriangleMesh AlphaWrap(const TriangleMesh& mesh, double gap, double offset);

/// Simplifies the solid to at most this number of triangles (Garland and Heckbert 1997). A smaller
/// mesh is returned unchanged.
/// @param mesh  from RepairMesh.
TriangleMesh Simplified(const TriangleMesh& mesh, std::size_t max_triangles);

/// How well convex parts approximate a solid, as shares of its volume.
struct Overlap {
  double covered = 0.0;  ///< volume of the solid inside the parts
  double beyond = 0.0;   ///< volume of the parts' union outside the solid
};
/// Counts the points of a regular lattice. Relative accuracy about 1 / sqrt(points inside).
/// @param mesh  from RepairMesh; parts are closed, convex, faces outward.
Overlap OverlapOf(const TriangleMesh& mesh, const std::vector<TriangleMesh>& parts);

/// The closed surface whose indicator function has the gradient that best fits oriented points
/// (Poisson reconstruction; Kazhdan, Bolitho and Hoppe 2006; CGAL's). The same points give the same
/// triangles.
/// @param cloud      at least 100 evenly distributed points with outward unit normals.
/// @param spacing_m  spacing of the points. Triangles deviate by at most 0.25 of it.
/// @return faces outward; nullopt if no surface fits.
/// @throws std::invalid_argument if there are too few points, or not one normal for each;
/// base::InputError if the mesher would run for minutes.
std::optional<TriangleMesh> PoissonSurface(const PointCloud& cloud, double spacing_m);

}  // namespace rangegrasp::geometry
