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

/// The part of a line from near_m to far_m behind its origin; the direction is a unit vector.
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
  /// Barycentric, of the triangle's second and third corner.
  float second = 0.0f;
  float third = 0.0f;
  Eigen::Vector3f normal_W = Eigen::Vector3f::Zero();  ///< unit, on the side the ray came from

  bool found() const { return mesh != kNone; }
};

/// Ray queries on a set of meshes in one frame W, which are copied. Owns an Embree device of its
/// own that uses the calling thread only, so that it may be made in a forked process. Neighboring
/// rays should be neighbors in space: they are traced 16 at a time.
class RayCaster {
 public:
  /// @throws std::invalid_argument naming the mesh and the vertex that is not finite or the
  /// triangle that has no such vertex.
  explicit RayCaster(std::span<const TriangleMesh* const> meshes);
  ~RayCaster();
  RayCaster(const RayCaster&) = delete;
  RayCaster& operator=(const RayCaster&) = delete;

  /// The first surface that each ray meets. O(log triangles) a ray.
  void FirstHits(std::span<const Ray> rays, std::vector<Hit>& hits) const;
  /// Whether each ray meets anything (1) or not (0).
  void Blocked(std::span<const Ray> rays, std::vector<std::uint8_t>& blocked) const;

 private:
  struct Embree;
  std::unique_ptr<Embree> embree_;
};

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
  /// Of each triangle's corners (NaN where nothing is printed); empty without a print.
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
