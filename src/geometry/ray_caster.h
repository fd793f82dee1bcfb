#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// The part of a line between near_m and far_m from its origin; the direction is a unit vector.
struct Ray {
  Eigen::Vector3f origin_W;
  Eigen::Vector3f direction_W;
  float near_m;
  float far_m;
};

struct Hit {
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  float distance_m = 0.0f;
  std::uint32_t mesh = kNone;
  std::uint32_t triangle = 0;
  /// Barycentric coordinates of the triangle's second and third corner.
  float second = 0.0f;
  float third = 0.0f;
  Eigen::Vector3f normal_W = Eigen::Vector3f::Zero();  ///< unit, on the side the ray came from

  bool found() const { return mesh != kNone; }
};

/// Ray queries on a set of meshes in one frame W, which are copied. It has an Embree device that
/// uses only the calling thread, so that it can be created in a forked process. Consecutive rays
/// should be close in space: they are traced 16 at a time.
class RayCaster {
 public:
  /// @throws std::invalid_argument naming a mesh's vertex that is not finite or does not exist.
  explicit RayCaster(std::span<const TriangleMesh* const> meshes);

  /// The first surface that each ray hits. O(log triangles) per ray.
  void FirstHits(std::span<const Ray> rays, std::vector<Hit>& hits) const;
  /// Whether each ray hits anything (1) or not (0).
  void Blocked(std::span<const Ray> rays, std::vector<std::uint8_t>& blocked) const;

 private:
  struct Embree;
  std::shared_ptr<Embree> embree_;
};

/// The print (texture) of a surface, row by row from v = 0.
struct Print {
  int width = 0;
  int height = 0;
  std::vector<Rgb> texels;
};

/// The colors of a mesh's triangles.
struct MeshColors {
  std::shared_ptr<const Print> print;  ///< null: nothing is printed
  /// Texture coordinates of triangles' corners (NaN: nothing is printed); empty without a print.
  /// They repeat outside [0, 1].
  std::vector<std::array<Eigen::Vector2f, 3>> uv;
  std::vector<Rgb> plain;  ///< color of each triangle where nothing is printed; empty: unknown

  /// The texel of the print at a hit of the mesh; nullopt where nothing is printed.
  std::optional<std::size_t> TexelAt(const Hit& hit) const;
  /// The printed color at a hit; nullopt where nothing is printed.
  std::optional<Rgb> PrintAt(const Hit& hit) const;
  /// The color at a hit; nullopt if it is unknown.
  std::optional<Rgb> At(const Hit& hit) const;
};

struct ColoredMesh {
  TriangleMesh mesh;
  MeshColors colors;
};

}  // namespace rangegrasp::geometry
