#pragma once

#include <span>
#include <vector>

#include "geometry/ray_caster.h"
#include "sim/visual_mesh.h"

namespace rangegrasp::sensing::internal {

using geometry::Hit;
using geometry::Ray;

/// Rays among what a sensor may see; Hit::mesh is the position in `meshes`.
class RayCaster : public geometry::RayCaster {
 public:
  /// @throws std::invalid_argument as geometry::RayCaster
  explicit RayCaster(std::span<const sim::VisualMesh> meshes)
      : geometry::RayCaster(SurfacesOf(meshes)) {}

 private:
  static std::vector<const geometry::TriangleMesh*> SurfacesOf(
      std::span<const sim::VisualMesh> meshes) {
    std::vector<const geometry::TriangleMesh*> surfaces;
    for (const sim::VisualMesh& mesh : meshes) surfaces.push_back(&mesh.mesh_W);
    return surfaces;
  }
};

}  // namespace rangegrasp::sensing::internal
