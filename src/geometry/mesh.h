#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "base/frames.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// A triangle mesh; faces are counter-clockwise seen from outside.
struct TriangleMesh {
  Points vertices;                                      ///< [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< positions in vertices
};

/// The mesh moved from frame B to frame A.
TriangleMesh Transformed(const TriangleMesh& mesh_B, const base::Pose& X_AB);

/// Appends `other` to `mesh`.
void Append(const TriangleMesh& other, TriangleMesh& mesh);

/// The enclosed volume [m^3] of a closed mesh (divergence theorem); negative if it is turned inside
/// out.
double Volume(const TriangleMesh& mesh);

}  // namespace rangegrasp::geometry
