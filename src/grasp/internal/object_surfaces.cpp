#include "grasp/internal/object_surfaces.h"

#include "grasp/surface.h"

namespace rangegrasp::grasp::internal {
namespace {

/// Grid of the specks that stand for objects whose surface is not known.
constexpr double kSpeckCell_m = 0.002;

}  // namespace

geometry::TriangleMesh SurfaceOf(const perception::PerceivedObject& object) {
  if (!object.surface_C.triangles.empty()) return object.surface_C;
  return SpeckMesh(object.completed_C, kSpeckCell_m);
}

std::vector<geometry::TriangleMesh> Others(const perception::Scene& scene, std::size_t own,
                                           std::span<const geometry::TriangleMesh> obstacles_C) {
  std::vector<geometry::TriangleMesh> surfaces(obstacles_C.begin(), obstacles_C.end());
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (i != own) surfaces.push_back(SurfaceOf(scene.objects[i]));
  }
  return surfaces;
}

}  // namespace rangegrasp::grasp::internal
