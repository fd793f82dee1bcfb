#pragma once

#include "geometry/mesh.h"
#include "perception/scene.h"

namespace rangegrasp::recognition {

struct LearnOptions {
  double spacing_m = 0.002;  ///< of the points from which the surface is made
  /// The lowest points of the sides are classified as table. The body is therefore assumed to stand
  /// where it was seen below this height above the table.
  double foot_m = 0.008;
};

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
/// @throws base::InputError if there is nothing on the table, or no surface fits.
LearntModel Learn(const perception::Scene& scene, const LearnOptions& options = {});

}  // namespace rangegrasp::recognition
