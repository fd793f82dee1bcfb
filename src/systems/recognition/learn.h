#pragma once

#include "geometry/mesh.h"
#include "perception/scene.h"

namespace rangegrasp::recognition {

/// Default spacing of the points from which a model is made: one point in each cell of this size.
inline constexpr double kLearnSpacing_m = 0.002;

/// A model of an object, learned from views of it.
struct LearntModel {
  /// Closed surface; z up from the table, origin on it below the middle of the bounding box.
  geometry::TriangleMesh mesh_B;
  base::Pose X_CB = base::Pose::Identity();
  double share_seen = 0.0;  ///< of its surface without the base, 0 to 1
};

/// Makes a model of the only object on a table from all views of a scene: its measured points with
/// their normals, and the table under it, closed by Poisson reconstruction (mesh/solid.h). Parts
/// that no view saw are closed smoothly.
/// @param spacing_m  of the points from which the surface is made
/// @throws base::InputError if there is nothing on the table, or too much for one object, or no
/// surface fits.
LearntModel Learn(const perception::Scene& scene, double spacing_m = kLearnSpacing_m);

}  // namespace rangegrasp::recognition
