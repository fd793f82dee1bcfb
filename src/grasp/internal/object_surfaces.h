#pragma once

#include <span>
#include <vector>

#include "geometry/mesh.h"
#include "perception/scene.h"

namespace rangegrasp::grasp::internal {

/// What stands for an object in collision checks: its surface, or specks where it has none.
geometry::TriangleMesh SurfaceOf(const perception::PerceivedObject& object);

/// Those of all objects but one, and obstacles.
std::vector<geometry::TriangleMesh> Others(const perception::Scene& scene, std::size_t own,
                                           std::span<const geometry::TriangleMesh> obstacles_C);

}  // namespace rangegrasp::grasp::internal
