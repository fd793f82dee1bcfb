#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "base/frames.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// A triangle mesh; faces are counter-clockwise seen from outside.
struct TriangleMesh {
  Points vertices;                                      ///< [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices into vertices
};

/// The mesh transformed from frame B to frame A.
TriangleMesh Transformed(const TriangleMesh& mesh_B, const base::Pose& X_AB);

/// Appends another mesh to `mesh`.
void Append(const TriangleMesh& other, TriangleMesh& mesh);

/// The volume [m^3] of a closed mesh (divergence theorem); negative if it is turned inside out.
double Volume(const TriangleMesh& mesh);

/// The axis-aligned bounding box of points; empty without a point.
inline Eigen::AlignedBox3d BoundsOf(PointSpan points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  return box;
}

/// p + u (q - p) + v (r - p), with (u, v) folded from the unit square into the triangle: uniform
/// over the triangle if (u, v) is uniform over the square.
inline Eigen::Vector3d TrianglePoint(const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                                     const Eigen::Vector3d& r, double u, double v) {
  if (u + v > 1.0) {
    u = 1.0 - u;
    v = 1.0 - v;
  }
  return p + u * (q - p) + v * (r - p);
}

/// Mass properties of a solid of density 1 inside a closed mesh, in the mesh's frame M.
struct MassProperties {
  double volume_m3 = 0.0;     ///< negative if the mesh is turned inside out
  Eigen::Vector3d center_M;   ///< [m]
  Eigen::Matrix3d inertia_M;  ///< [m^5] about the center, along the axes of M
};

/// Exact sums over the tetrahedra that the triangles form with one point: volume det(a b c) / 6,
/// first moment V (a + b + c) / 4, second moment V (sum_i p_i p_i^T + s s^T) / 20 with s = a + b +
/// c (Tonon 2005). O(triangles). The center is the mesh's first vertex if the volume is 0.
MassProperties MassPropertiesOf(const TriangleMesh& mesh);

/// The convex hull (eq. 5.1) as a closed mesh, faces outward; empty if the points are (nearly) in
/// one plane. Vertices and triangles are sorted: the same points give the same bytes.
TriangleMesh ConvexHull(PointSpan points);

}  // namespace rangegrasp::geometry
