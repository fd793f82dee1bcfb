#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "geometry/ray_caster.h"
#include "pcl_bridge/registration.h"
#include "recognition/internal/pair_table.h"
#include "recognition/internal/revolution.h"
#include "recognition/internal/tone.h"
#include "recognition/library.h"

namespace rangegrasp::recognition::internal {

/// One known object, made ready to be looked for.
struct PreparedObject {
  PreparedObject(const KnownObject& object, const LibraryOptions& options);

  const KnownObject* object;
  geometry::RayCaster rays;        ///< the mesh in B
  MeshTones tones;                 ///< of the mesh
  pcl_bridge::PlaneTarget target;  ///< surface_B
  geometry::Points hull_B;         ///< corners of the hull
  Eigen::Matrix3d axes_B;          ///< principal ones, unit columns
  std::optional<Axis> round;       ///< most of it is round about this
  /// Ways to lie on a table whose frame has z up: rotations R_TB that symmetry does not map onto
  /// each other.
  std::vector<Eigen::Matrix3d> lying;
  PairTable pairs;
};

}  // namespace rangegrasp::recognition::internal

namespace rangegrasp::recognition {

struct Library::Prepared {
  std::vector<KnownObject> objects;
  std::vector<std::unique_ptr<internal::PreparedObject>> ready;  ///< in their order
};

}  // namespace rangegrasp::recognition
