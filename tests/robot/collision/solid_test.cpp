#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "robot/collision/collider.h"

namespace rangegrasp::collision {
namespace {

using Kind = geometry::Shape::Kind;

base::Pose SolidRandomPose(base::Rng& rng) {
  Eigen::Vector3d axis(rng.Normal(), rng.Normal(), rng.Normal());
  const double angle = rng.Uniform(-3.0, 3.0);
  const Eigen::Vector3d p(rng.Uniform(-0.1, 0.1), rng.Uniform(-0.1, 0.1), rng.Uniform(-0.1, 0.1));
  return base::MakePose(Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(), p);
}

/// The surface point of the shape, in its frame, for a direction.
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

// Bounds and lowest points are exact: no surface point lies outside, and samples in many directions
// come close. 20000 directions are about 0.025 rad apart: r (1 - cos 0.025) < 0.1 mm.
TEST(Solid, BoundsEncloseEverySurfacePointTightly) {
  base::Rng rng(3);
  for (Kind kind : {Kind::kSphere, Kind::kCapsule, Kind::kCylinder, Kind::kBox, Kind::kEllipsoid}) {
    geometry::Shape shape;
    shape.kind = kind;
    shape.size = {0.04, 0.06, 0.03};
    const base::Pose X_WS = SolidRandomPose(rng);
    const Solid solid(shape);
    const Eigen::AlignedBox3d box = solid.BoxAt(X_WS);
    double lowest = 1.0;
    for (int i = 0; i < 20000; ++i) {
      Eigen::Vector3d d(rng.Normal(), rng.Normal(), rng.Normal());
      const Eigen::Vector3d p = X_WS * SurfacePoint(shape, d.normalized());
      ASSERT_TRUE((p.array() >= box.min().array() - 1e-12).all());
      ASSERT_TRUE((p.array() <= box.max().array() + 1e-12).all());
      lowest = std::min(lowest, p.z());
    }
    EXPECT_NEAR(lowest, box.min().z(), 2e-4) << static_cast<int>(kind);
    EXPECT_NEAR(solid.LowestAt(X_WS), box.min().z(), 1e-15);
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

// A capsule above a box mesh moves down past contact. The margin takes effect at exactly its
// distance.
TEST(Solid, MarginIsFeltAtItsDistance) {
  geometry::Shape capsule;
  capsule.kind = Kind::kCapsule;
  capsule.size = {0.02, 0.05, 0.0};
  const Solid box(BoxMesh({0.1, 0.1, 0.05}));
  const base::Pose lying = base::MakePose(
      Eigen::AngleAxisd(1.5707963267948966, Eigen::Vector3d::UnitY()).toRotationMatrix(),
      Eigen::Vector3d::Zero());
  for (double margin_m : {0.0, 0.003, 0.01}) {
    const Solid solid(capsule, {margin_m});
    base::Pose X = lying;
    X.translation() = Eigen::Vector3d(0.01, 0.02, 0.05 + 0.02 + margin_m + 1e-4);
    EXPECT_FALSE(solid.Touches(X, box, base::Pose::Identity()));
    X.translation().z() -= 2e-4;
    EXPECT_TRUE(solid.Touches(X, box, base::Pose::Identity()));
  }
}

geometry::Shape MakeShape(Kind kind, const Eigen::Vector3d& size) {
  geometry::Shape shape;
  shape.kind = kind;
  shape.size = size;
  return shape;
}

base::Pose At(double x, double y, double z) {
  return base::MakePose(Eigen::Matrix3d::Identity(), {x, y, z});
}

// A sphere approaches a box of half sizes (0.1, 0.2, 0.3) along the normal of a face, an edge and a
// corner. It touches when its centre is one radius away from the nearest point of the box.
TEST(Solid, SphereTouchesABoxAtItsRadius) {
  const Solid box(MakeShape(Kind::kBox, {0.1, 0.2, 0.3}));
  const Solid surface(BoxMesh({0.1, 0.2, 0.3}));
  const double radius_m = 0.05;
  const Solid sphere(MakeShape(Kind::kSphere, {radius_m, 0.0, 0.0}));
  const std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> nearest{
      {{0.1, 0.05, -0.1}, {1, 0, 0}},
      {{0.1, 0.2, 0.02}, {1, 1, 0}},
      {{-0.1, 0.2, 0.3}, {-1, 1, 1}}};
  for (const auto& [point, way] : nearest) {
    for (const double off_m : {-1e-4, 1e-4}) {
      const Eigen::Vector3d p = point + (radius_m + off_m) * way.normalized();
      const base::Pose X = At(p.x(), p.y(), p.z());
      EXPECT_EQ(sphere.Touches(X, box, base::Pose::Identity()), off_m < 0.0) << way.transpose();
      EXPECT_EQ(sphere.Touches(X, surface, base::Pose::Identity()), off_m < 0.0) << way.transpose();
      EXPECT_EQ(Hit(Place(sphere, X), Place(box, base::Pose::Identity())), off_m < 0.0);
    }
  }
}

// A capsule leans by an angle from the vertical. Its lowest point is half its length times the
// cosine, plus its radius, below its center.
TEST(Solid, CapsuleStandsOnAPlaneAtItsSupport) {
  const Solid capsule(MakeShape(Kind::kCapsule, {0.02, 0.1, 0.0}));
  for (const double lean_rad : {0.0, 0.3, 1.0, 1.5}) {
    const base::Pose X = base::MakePose(
        Eigen::AngleAxisd(lean_rad, Eigen::Vector3d::UnitX()).toRotationMatrix(), {0.0, 0.0, 0.5});
    EXPECT_NEAR(capsule.LowestAt(X), 0.5 - 0.1 * std::cos(lean_rad) - 0.02, 1e-12);
  }
}

// An independent check with samples of a shape's surface 1 mm apart against the box |p| <= half,
// where the samples do not graze the box.
TEST(Solid, AgreesWithSampledPointsInAnyPose) {
  base::Rng rng(31);
  const Eigen::Vector3d half(0.05, 0.03, 0.08);
  const Solid box(MakeShape(Kind::kBox, half));
  int hits = 0;
  int decided = 0;
  for (const Kind kind : {Kind::kSphere, Kind::kCapsule, Kind::kCylinder, Kind::kEllipsoid}) {
    const geometry::Shape shape = MakeShape(kind, {0.03, 0.04, 0.02});
    const Solid solid(shape);
    const geometry::TriangleMesh fine = geometry::Tessellate(shape, 180);
    for (int i = 0; i < 100; ++i) {
      const base::Pose X = SolidRandomPose(rng);
      double min = 1.0;
      for (const Eigen::Vector3d& p : fine.vertices) {
        min = std::min(min, ((X * p).cwiseAbs() - half).maxCoeff());
      }
      const bool hit = solid.Touches(X, box, base::Pose::Identity());
      hits += hit;
      // If a sample lies in the box, the two touch.
      if (min < 0.0) {
        EXPECT_TRUE(hit) << static_cast<int>(kind) << " " << i;
      }
      // If the box grown by 3 mm contains no sample, they do not touch: with 180 sides, vertices on
      // round parts are at most 0.04 pi / 90 = 1.4 mm apart. A cylinder's wall has vertices only at
      // its ends and is not decided here.
      if (kind != Kind::kCylinder && kind != Kind::kCapsule && min > 0.003) {
        EXPECT_FALSE(hit) << static_cast<int>(kind) << " " << i;
        ++decided;
      }
    }
  }
  EXPECT_GT(hits, 80);
  EXPECT_GT(decided, 30);
}

TEST(Solid, WithoutTrianglesTouchesNothing) {
  const Solid empty{geometry::TriangleMesh()};
  const Solid sphere(MakeShape(Kind::kSphere, {1.0, 0.0, 0.0}));
  EXPECT_TRUE(empty.IsEmpty());
  EXPECT_FALSE(empty.Touches(base::Pose::Identity(), sphere, base::Pose::Identity()));
  EXPECT_FALSE(Hit(Place(sphere, base::Pose::Identity()), Place(empty, base::Pose::Identity())));
}

}  // namespace
}  // namespace rangegrasp::collision
