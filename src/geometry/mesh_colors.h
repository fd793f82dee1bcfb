#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/color.h"
#include "geometry/ray_caster.h"

namespace rangegrasp::geometry {

/// What is printed on a surface, row by row from v = 0.
struct Print {
  int width = 0;
  int height = 0;
  std::vector<Rgb> texels;

  /// The texel at a texture coordinate; repeats beyond 0 to 1.
  std::size_t IndexAt(const Eigen::Vector2f& uv) const;
};

/// The colors of a mesh's triangles.
struct MeshColors {
  std::shared_ptr<const Print> print;  ///< null: nothing is printed
  /// Texture coordinates of each triangle's corners (NaN where nothing is printed); empty without a
  /// print.
  std::vector<std::array<Eigen::Vector2f, 3>> uv;
  std::vector<Rgb> plain;  ///< of each triangle where nothing is printed; empty: not known

  /// The print's texel where a ray met the mesh; nullopt where nothing is printed.
  std::optional<std::size_t> TexelAt(const Hit& hit) const;
  /// What is printed there.
  std::optional<Rgb> PrintAt(const Hit& hit) const;
  /// The color there; nullopt where it is not known.
  std::optional<Rgb> At(const Hit& hit) const;
};

struct ColoredMesh {
  TriangleMesh mesh;
  MeshColors colors;
};

}  // namespace rangegrasp::geometry
