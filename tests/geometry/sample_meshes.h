#pragma once

#include <algorithm>
#include <map>
#include <utility>

#include "geometry/shape.h"

namespace rangegrasp::geometry::samples {

inline TriangleMesh BoxMesh(const Eigen::Vector3d& half,
                            const Eigen::Vector3d& center = {0.0, 0.0, 0.0}) {
  Shape box;
  box.kind = Shape::Kind::kBox;
  box.size = half;
  box.X_BS.translation() = center;
  return Tessellate(box);
}

/// True if each edge is shared by two triangles that traverse it in opposite directions.
inline bool IsClosed(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  }
  return !edges.empty() && std::ranges::all_of(edges, [&edges](const auto& edge) {
    return edge.second == 1 && edges.contains({edge.first.second, edge.first.first});
  });
}

}  // namespace rangegrasp::geometry::samples
