#include "sensing/internal/ray_caster.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <optional>

#include "base/rng.h"
#include "geometry/random_points.h"
#include "sensing/shapes.h"

namespace rangegrasp::sensing::internal {
namespace {

using Eigen::Vector3d;
using geometry::samples::RandomDirection;
using geometry::samples::RandomPoint;

std::vector<sim::VisualMesh> RandomTriangles(base::Rng& rng) {
  std::vector<sim::VisualMesh> meshes(5);
  for (auto& mesh : meshes) {
    for (std::uint32_t t = 0; t < 20; ++t) {
      const Vector3d center = RandomPoint(1.0, rng);
      for (int k = 0; k < 3; ++k)
        mesh.mesh_W.vertices.push_back(center + 0.4 * RandomPoint(1.0, rng));
      mesh.mesh_W.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
  }
  return meshes;
}

/// A crossing found by solving o + t d = a + u (b - a) + v (c - a); `margin` is how far inside the
/// triangle it lies, negative outside.
struct Crossing {
  double distance_m;
  double margin;
};

std::optional<Crossing> Cross(const Vector3d& o, const Vector3d& d, const Vector3d& a,
                              const Vector3d& b, const Vector3d& c) {
  Eigen::Matrix3d m;
  m << -d, b - a, c - a;
  if (std::abs(m.determinant()) < 1e-9) return std::nullopt;
  const Vector3d tuv = m.fullPivLu().solve(o - a);
  return Crossing{tuv.x(), std::min({tuv.y(), tuv.z(), 1.0 - tuv.y() - tuv.z()})};
}

struct Reference {
  double distance_m = std::numeric_limits<double>::infinity();
  std::uint32_t mesh = Hit::kNone;
  Vector3d normal = Vector3d::Zero();
  bool doubtful = false;  ///< passes a triangle's edge or the near end within rounding
};

Reference BruteForce(std::span<const sim::VisualMesh> meshes, const Ray& ray) {
  Reference best;
  const Vector3d o = ray.origin_W.cast<double>();
  const Vector3d d = ray.direction_W.cast<double>();
  for (std::uint32_t i = 0; i < meshes.size(); ++i) {
    const auto& v = meshes[i].mesh_W.vertices;
    for (const auto& t : meshes[i].mesh_W.triangles) {
      const auto crossing = Cross(o, d, v[t[0]], v[t[1]], v[t[2]]);
      if (!crossing || crossing->distance_m < 0.0) continue;
      const double from_near = crossing->distance_m - static_cast<double>(ray.near_m);
      if (std::abs(crossing->margin) < 1e-4 ||
          (crossing->margin > 0.0 && std::abs(from_near) < 1e-5)) {
        best.doubtful = true;
      }
      if (crossing->margin < 0.0 || from_near < 0.0) continue;
      if (crossing->distance_m >= best.distance_m) continue;
      best.distance_m = crossing->distance_m;
      best.mesh = i;
      best.normal = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).normalized();
    }
  }
  return best;
}

TEST(RayCaster, AgreesWithBruteForceOnRandomScenes) {
  int compared = 0;
  int found = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    base::Rng rng(seed);
    const auto meshes = RandomTriangles(rng);
    const RayCaster caster(meshes);
    std::vector<Ray> rays;
    for (int i = 0; i < 203; ++i) {  // not a multiple of a packet
      const Vector3d origin = 1.5 * RandomPoint(1.0, rng);
      rays.push_back({origin.cast<float>(), RandomDirection(rng).cast<float>(), 0.1f, 10.0f});
    }
    std::vector<Hit> hits;
    std::vector<std::uint8_t> blocked;
    caster.FirstHits(rays, hits);
    caster.Blocked(rays, blocked);
    ASSERT_EQ(hits.size(), rays.size());
    ASSERT_EQ(blocked.size(), rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Reference reference = BruteForce(meshes, rays[i]);
      if (reference.doubtful) continue;
      ++compared;
      ASSERT_EQ(hits[i].mesh, reference.mesh) << "seed " << seed << " ray " << i;
      EXPECT_EQ(blocked[i] != 0, hits[i].found());
      if (!hits[i].found()) continue;
      ++found;
      // Coordinates up to 2 m in single precision, at a slant: some 1e-6 m.
      EXPECT_NEAR(hits[i].distance_m, reference.distance_m, 2e-5);
      EXPECT_NEAR(std::abs(hits[i].normal_W.cast<double>().dot(reference.normal)), 1.0, 1e-4);
      EXPECT_LE(hits[i].normal_W.dot(rays[i].direction_W), 0.0f);
    }
  }
  EXPECT_GT(compared, 3500);
  EXPECT_GT(found, 700);
}

TEST(RayCaster, RespectsBothEndsOfARay) {
  const std::vector meshes = {test::Level(1.0, -1, 1, -1, 1)};
  const RayCaster caster(meshes);
  const Eigen::Vector3f o = Eigen::Vector3f::Zero();
  const Eigen::Vector3f up = Eigen::Vector3f::UnitZ();
  const std::vector<Ray> rays = {
      {o, up, 0.0f, 2.0f}, {o, up, 1.5f, 2.0f}, {o, up, 0.0f, 0.5f}, {o, up, 0.5f, -0.5f}};
  std::vector<std::uint8_t> blocked;
  caster.Blocked(rays, blocked);
  EXPECT_EQ(blocked, (std::vector<std::uint8_t>{1, 0, 0, 0}));
}

TEST(RayCaster, WithoutMeshesNothingIsMet) {
  const RayCaster caster({});
  const std::vector<Ray> rays(3, {Eigen::Vector3f::Zero(), Eigen::Vector3f::UnitX(), 0.0f, 9.0f});
  std::vector<Hit> hits;
  caster.FirstHits(rays, hits);
  for (const Hit& hit : hits) EXPECT_FALSE(hit.found());
}

}  // namespace
}  // namespace rangegrasp::sensing::internal
