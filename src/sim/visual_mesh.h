#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "geometry/mesh.h"

namespace rangegrasp::sim {

/// How a surface answers to a red laser line (635 nm).
struct OpticalSurface {
  double albedo = 0.7;   ///< 0..1, diffuse
  double gloss = 0.0;    ///< 0..1, share of mirror-like reflection
  double clarity = 0.0;  ///< 0..1, 1 = fully clear
};

/// The red channel (sRGB) of what is printed on a surface, row by row from v = 0.
struct Print {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> red;

  /// At a texture coordinate; repeats beyond 0 to 1.
  std::uint8_t At(const Eigen::Vector2f& uv) const {
    const auto texel = [](float place, int size) {
      const float wrapped = place - std::floor(place);
      return static_cast<std::size_t>(
          std::min(static_cast<int>(wrapped * static_cast<float>(size)), size - 1));
    };
    return red[texel(uv.y(), height) * static_cast<std::size_t>(width) + texel(uv.x(), width)];
  }
};

/// The label of an open box that objects lie in: above those of all objects.
inline constexpr std::uint32_t kContainerLabel = 1000;

/// What a sensor may see: a surface in the world with the label that the scorer alone may read.
struct VisualMesh {
  geometry::TriangleMesh mesh_W;
  OpticalSurface surface;
  /// What is printed on it, and the texture coordinates of each triangle's corners (NaN where
  /// nothing is); there the print's albedo goes before the surface's. Empty where nothing is.
  std::shared_ptr<const Print> print;
  std::vector<std::array<Eigen::Vector2f, 3>> uv;
  std::uint32_t label = 0;  ///< 0: the scene (table, robot, ...); object i has label i + 1;
                            ///< an open box that they lie in has kContainerLabel
};

}  // namespace rangegrasp::sim
