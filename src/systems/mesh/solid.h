#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

struct RepairOptions {
  /// A hole across at most this share of the mesh's diagonal is closed: what scans and exporters
  /// leave. A larger one may be the mouth of a cup whose wall has no thickness.
  double max_hole = 0.2;
  /// A surface that crosses itself is wrapped anew: a new one stands off by this share of the
  /// diagonal (0.3 mm of 170 mm: the noise of a good scanner) and bridges gaps ten times as wide.
  double wrap_offset = 0.0018;
  double wrap_gap = 0.018;
  /// Less volume than this share of the diagonal's cube is no solid but a sheet (paper: 4e-5).
  double min_volume = 1e-5;
};

/// A mesh that bounds a solid: closed, each edge between two triangles, no triangle through
/// another, faces outward.
struct Repaired {
  TriangleMesh mesh;
  std::vector<std::string> done;   ///< what was wrong and what was done, a sentence each
  bool turned_inside_out = false;  ///< the faces of what was given pointed inward
};

/// Joins equal vertices, drops triangles without area, orients them alike, stitches borders, closes
/// small holes, turns faces outward (CGAL). The same mesh gives the same bytes.
/// @param mesh  in any unit; all coordinates finite.
/// @throws base::InputError with the reason where that is not enough: a large hole, no volume.
Repaired RepairMesh(const TriangleMesh& mesh, const RepairOptions& options = {});

/// A closed surface about a mesh: CGAL's alpha wrap (Portaneri et al. 2022). It crosses gaps and
/// gives what has no thickness one; faces grow with `gap`. The same mesh gives the same bytes.
/// @param gap     > 0; radius of the balls that do not pass what is bridged
/// @param offset  > 0; how far it stands off
TriangleMesh AlphaWrap(const TriangleMesh& mesh, double gap, double offset);

/// The solid with at most so many triangles (Garland and Heckbert 1997); itself if it has no more.
/// @param mesh  as RepairMesh makes it.
TriangleMesh Simplified(const TriangleMesh& mesh, std::size_t max_triangles);

/// How well convex parts stand for a solid, as shares of its volume.
struct Overlap {
  double covered = 0.0;  ///< of the solid, inside of parts
  double beyond = 0.0;   ///< of the parts' union, outside of the solid
};
/// By counting the points of a regular lattice: good to about 1 / sqrt(points inside).
/// @param mesh  as RepairMesh makes it; parts are closed, convex, faces outward.
Overlap OverlapOf(const TriangleMesh& mesh, const std::vector<TriangleMesh>& parts);

/// The closed surface whose gradient of inside and outside fits oriented points best (Poisson
/// reconstruction; Kazhdan, Bolitho and Hoppe 2006; CGAL's). The same points give the same
/// triangles.
/// @param cloud      with outward unit normals, evenly spread; 100 points at least.
/// @param spacing_m  of its points: triangles stand off by 0.25 of it at most.
/// @return faces outward; nullopt if no surface fits.
/// @throws std::invalid_argument if points and normals are not as many, or too few;
/// base::InputError if the mesher would go on for minutes.
std::optional<TriangleMesh> PoissonSurface(const PointCloud& cloud, double spacing_m);

}  // namespace rangegrasp::geometry
