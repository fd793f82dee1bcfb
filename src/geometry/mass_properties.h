#pragma once

#include <Eigen/Core>

#include "geometry/mesh.h"

namespace rangegrasp::geometry {

/// Of a solid of density 1 inside a closed mesh, in the mesh's frame M.
struct MassProperties {
  double volume_m3 = 0.0;     ///< negative if the mesh is turned inside out
  Eigen::Vector3d center_M;   ///< [m]
  Eigen::Matrix3d inertia_M;  ///< [m^5] about the center, along the axes of M
};

/// Exact sums over the tetrahedra that the triangles span with one point: volume det(a b c) / 6,
/// first moment V (a + b + c) / 4, second moment V (sum_i p_i p_i^T + s s^T) / 20 with s = a + b +
/// c (Tonon 2005). O(triangles). The center is the mesh's first vertex where the volume is 0.
MassProperties MassPropertiesOf(const TriangleMesh& mesh);

}  // namespace rangegrasp::geometry
