#include "planning/internal/solid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/rng.h"

namespace rangegrasp::planning::internal {
namespace {

using Kind = geometry::Shape::Kind;

core::Pose RandomPose(core::Rng& rng) {
  Eigen::Vector3d axis(rng.Normal(), rng.Normal(), rng.Normal());
  const double angle = rng.Uniform(-3.0, 3.0);
  const Eigen::Vector3d p(rng.Uniform(-0.1, 0.1), rng.Uniform(-0.1, 0.1), rng.Uniform(-0.1, 0.1));
  return core::MakePose(Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(), p);
}

/// A point of the shape's surface, in its frame, from a direction.
Eigen::Vector3d SurfacePoint(const geometry::Shape& shape, const Eigen::Vector3d& d) {
  const Eigen::Vector3d& s = shape.size;
  const double side = d.z() > 0.0 ? 1.0 : -1.0;
  switch (shape.kind) {
    case Kind::kSphere:
      return s[0] * d;
    case Kind::kCapsule:
      return s[0] * d + Eigen::Vector3d(0, 0, side * s[1]);
    case Kind::kCylinder:
      return {s[0] * d.x() / d.head<2>().norm(), s[0] * d.y() / d.head<2>().norm(), side * s[1]};
    case Kind::kEllipsoid:
      return s.cwiseProduct(d);
    default:
      return s.cwiseProduct(d.cwiseSign());
  }
}

// Bounds and lowest points are exact: no surface point lies outside, and the densest of many
// directions come near. 20000 directions are about 0.025 rad apart: r (1 - cos 0.025) < 0.1 mm.
TEST(Solid, BoundsEncloseEverySurfacePointTightly) {
  core::Rng rng(3);
  for (Kind kind : {Kind::kSphere, Kind::kCapsule, Kind::kCylinder, Kind::kBox, Kind::kEllipsoid}) {
    geometry::Shape shape;
    shape.kind = kind;
    shape.size = {0.04, 0.06, 0.03};
    const core::Pose X_WS = RandomPose(rng);
    const Solid solid(shape, 0.0);
    const Bounds bounds = solid.BoundsAt(X_WS);
    double lowest = 1.0;
    for (int i = 0; i < 20000; ++i) {
      Eigen::Vector3d d(rng.Normal(), rng.Normal(), rng.Normal());
      const Eigen::Vector3d p = X_WS * SurfacePoint(shape, d.normalized());
      ASSERT_TRUE((p.array() >= bounds.low.array() - 1e-12).all());
      ASSERT_TRUE((p.array() <= bounds.high.array() + 1e-12).all());
      lowest = std::min(lowest, p.z());
    }
    EXPECT_NEAR(lowest, bounds.low.z(), 2e-4) << static_cast<int>(kind);
    EXPECT_EQ(solid.LowestAt(X_WS), bounds.low.z());
  }
}

geometry::TriangleMesh BoxMesh(const Eigen::Vector3d& half) {
  geometry::TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1 ? 1 : -1) * half.x(), (i & 2 ? 1 : -1) * half.y(),
                               (i & 4 ? 1 : -1) * half.z());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

// A capsule above a box mesh, moved down past contact: the margin is felt at just that distance.
TEST(Solid, MarginIsFeltAtItsDistance) {
  geometry::Shape capsule;
  capsule.kind = Kind::kCapsule;
  capsule.size = {0.02, 0.05, 0.0};
  const Solid box(BoxMesh({0.1, 0.1, 0.05}));
  const core::Pose lying = core::MakePose(
      Eigen::AngleAxisd(1.5707963267948966, Eigen::Vector3d::UnitY()).toRotationMatrix(),
      Eigen::Vector3d::Zero());
  for (double margin_m : {0.0, 0.003, 0.01}) {
    const Solid solid(capsule, margin_m);
    core::Pose X = lying;
    X.translation() = Eigen::Vector3d(0.01, 0.02, 0.05 + 0.02 + margin_m + 1e-4);
    EXPECT_FALSE(solid.Hits(X, box, core::Pose::Identity()));
    X.translation().z() -= 2e-4;
    EXPECT_TRUE(solid.Hits(X, box, core::Pose::Identity()));
  }
}

}  // namespace
}  // namespace rangegrasp::planning::internal
