#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>

#include "base/units.h"
#include "sim/world.h"

namespace rangegrasp::sensing::test {

/// A parallelogram given by a corner and two edges.
inline sim::VisualMesh Plate(const Eigen::Vector3d& corner, const Eigen::Vector3d& edge_u,
                             const Eigen::Vector3d& edge_v, std::uint32_t label = 0) {
  sim::VisualMesh mesh;
  mesh.label = label;
  mesh.mesh_W.vertices = {corner, corner + edge_u, corner + edge_v, corner + edge_u + edge_v};
  mesh.mesh_W.triangles = {{0, 1, 2}, {1, 3, 2}};
  return mesh;
}

/// The rectangle x0..x1, y0..y1 at height z.
inline sim::VisualMesh Level(double z, double x0, double x1, double y0, double y1,
                             std::uint32_t label = 0) {
  return Plate({x0, y0, z}, {x1 - x0, 0, 0}, {0, y1 - y0, 0}, label);
}

inline sim::VisualMesh Box(const Eigen::Vector3d& center, const Eigen::Vector3d& half,
                           std::uint32_t label = 0) {
  sim::VisualMesh mesh;
  mesh.label = label;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d sign((i & 1) ? 1 : -1, (i & 2) ? 1 : -1, (i & 4) ? 1 : -1);
    mesh.mesh_W.vertices.push_back(center + half.cwiseProduct(sign));
  }
  mesh.mesh_W.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                           {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// A sphere of `rings` x 2 `rings` quads with its vertices on the surface.
inline sim::VisualMesh Sphere(const Eigen::Vector3d& center, double radius, int rings,
                              std::uint32_t label = 0) {
  sim::VisualMesh mesh;
  mesh.label = label;
  const auto id = [rings](int i, int j) {
    return static_cast<std::uint32_t>(i * (2 * rings + 1) + j);
  };
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j <= 2 * rings; ++j) {
      const double a = base::kPi * i / rings;
      const double b = base::kPi * j / rings;
      mesh.mesh_W.vertices.push_back(center + radius * Eigen::Vector3d(std::sin(a) * std::cos(b),
                                                                       std::sin(a) * std::sin(b),
                                                                       std::cos(a)));
      if (i == rings || j == 2 * rings) continue;
      mesh.mesh_W.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mesh.mesh_W.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  return mesh;
}

}  // namespace rangegrasp::sensing::test
