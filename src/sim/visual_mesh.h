#pragma once

#include <cstdint>

#include "geometry/mesh.h"
#include "geometry/ray_caster.h"

namespace rangegrasp::sim {

/// How a surface reflects a red laser line (635 nm).
struct OpticalSurface {
  double albedo = 0.7;   ///< 0..1, diffuse
  double gloss = 0.0;    ///< 0..1, share of mirror-like reflection
  double clarity = 0.0;  ///< 0..1, 1 = fully clear
};

/// The label of an open box that objects lie in; it is above the labels of all objects.
inline constexpr std::uint32_t kContainerLabel = 1000;

/// A surface in the world that a sensor may see, with a label that only the scorer may read.
struct VisualMesh {
  geometry::TriangleMesh mesh_W;
  OpticalSurface surface;
  geometry::MeshColors colors;  ///< a print's albedo takes precedence over the surface's
  std::uint32_t label = 0;      ///< 0: the scene (table, robot, ...); object i has label i + 1;
                                ///< an open box that they lie in has kContainerLabel
};

}  // namespace rangegrasp::sim
