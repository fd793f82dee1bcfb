#pragma once

#include "geometry/mesh.h"
#include "perception/scene.h"

namespace rangegrasp::recognition {

struct LearnOptions {
  double spacing_m = 0.002;  ///< of the points that the surface is made of
  /// The body stands where it was seen this low above the table: the sides end there, since the
  /// lowest of them are taken for the table's.
  double foot_m = 0.008;
};

/// A thing as views of it show it.
struct LearntModel {
  /// A closed surface; z up from the table, origin on it below the middle of the thing's box.
  geometry::TriangleMesh mesh_B;
  base::Pose X_CB = base::Pose::Identity();
  double share_seen = 0.0;  ///< of its surface but for what it stands on, 0 to 1
};

/// A model of the one thing that stands on a table, from all views that a scene was perceived from:
/// its measured points with their normals, and the table where it stands on it, closed by Poisson's
/// reconstruction (mesh/solid.h). What no view saw is closed smoothly.
/// @throws base::InputError if there is nothing on the table, or no surface fits.
LearntModel Learn(const perception::Scene& scene, const LearnOptions& options = {});

}  // namespace rangegrasp::recognition
