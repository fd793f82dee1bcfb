#include "geometry/shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "base/units.h"
#include "geometry/random_points.h"
#include "geometry/sample_meshes.h"

namespace rangegrasp::geometry {
namespace {

using base::kPi;

Shape Make(Shape::Kind kind, const Eigen::Vector3d& size) {
  Shape shape;
  shape.kind = kind;
  shape.size = size;
  return shape;
}

TEST(Shape, TessellationsAreClosedAndComeNearTheSolidsVolume) {
  const double r = 0.3;
  const double h = 0.5;
  const std::vector<std::pair<Shape, double>> shapes = {
      {Make(Shape::Kind::kSphere, {r, 0.0, 0.0}), 4.0 / 3.0 * kPi * r * r * r},
      {Make(Shape::Kind::kCapsule, {r, h, 0.0}),
       4.0 / 3.0 * kPi * r * r * r + kPi * r * r * 2.0 * h},
      {Make(Shape::Kind::kCylinder, {r, h, 0.0}), kPi * r * r * 2.0 * h},
      {Make(Shape::Kind::kBox, {0.1, 0.2, 0.3}), 8.0 * 0.1 * 0.2 * 0.3},
      {Make(Shape::Kind::kEllipsoid, {0.1, 0.2, 0.3}), 4.0 / 3.0 * kPi * 0.1 * 0.2 * 0.3}};
  for (const auto& [shape, volume] : shapes) {
    const TriangleMesh mesh = Tessellate(shape, 128);
    EXPECT_TRUE(samples::IsClosed(mesh));
    // With steps of h = 2 pi / n, an inscribed polygon loses h^2 / 6 of a circle's area, and a
    // profile of chords loses h^2 / 4 of a sphere's volume: 5 / 12 together, plus higher orders.
    EXPECT_LE(Volume(mesh), volume * (1.0 + 1e-12));
    EXPECT_GE(Volume(mesh), volume * (1.0 - 0.43 * std::pow(2.0 * kPi / 128.0, 2)));
    EXPECT_TRUE(samples::IsClosed(Tessellate(shape, 3)));
    EXPECT_GT(Volume(Tessellate(shape, 3)), 0.0);
  }
}

TEST(Shape, ConvexIsTheHullOfItsMeshAndMeshStaysAsItIs) {
  base::Rng rng(3);
  Shape shape = Make(Shape::Kind::kConvex, Eigen::Vector3d::Zero());
  shape.mesh = Tessellate(Make(Shape::Kind::kBox, {0.5, 0.5, 0.5}));
  for (int i = 0; i < 50; ++i) shape.mesh.vertices.push_back(samples::RandomPoint(0.4, rng));
  const TriangleMesh hull = Tessellate(shape);
  EXPECT_EQ(hull.vertices.size(), 8u);
  EXPECT_NEAR(Volume(hull), 1.0, 1e-12);
  shape.kind = Shape::Kind::kMesh;
  EXPECT_EQ(Tessellate(shape).vertices, shape.mesh.vertices);
}

TEST(Shape, ThePoseMovesTheSurface) {
  Shape shape = Make(Shape::Kind::kSphere, {0.1, 0.0, 0.0});
  shape.X_BS = base::MakePose(Eigen::Matrix3d::Identity(), {1.0, 2.0, 3.0});
  for (const Eigen::Vector3d& p : Tessellate(shape).vertices) {
    EXPECT_NEAR((p - Eigen::Vector3d(1.0, 2.0, 3.0)).norm(), 0.1, 1e-12);
  }
  EXPECT_THROW(Tessellate(shape, 2), std::invalid_argument);
}

using Eigen::Vector3d;
using Kind = Shape::Kind;

constexpr std::array kRound{Kind::kSphere, Kind::kCapsule, Kind::kCylinder, Kind::kBox,
                            Kind::kEllipsoid};

Shape Turned(Kind kind) {
  Shape shape = Make(kind, {0.02, 0.03, 0.05});
  shape.X_BS = base::MakePose(Eigen::AngleAxisd(0.4, Vector3d::UnitX()).toRotationMatrix(),
                              Vector3d(0.01, 0.02, 0.03));
  return shape;
}

TEST(Support, IsTheFarthestVertex) {
  base::Rng rng(9);
  for (const Kind kind : kRound) {
    const Shape shape = Turned(kind);
    for (int i = 0; i < 20; ++i) {
      const Vector3d d = samples::RandomPoint(1.0, rng).normalized();
      double farthest = -1.0;
      for (const Vector3d& p : Tessellate(shape, 96).vertices) {
        farthest = std::max(farthest, d.dot(p));
      }
      // 96 sides: 0.05 % of at most 50 mm, in both directions of curvature.
      EXPECT_NEAR(Support(shape, base::Pose::Identity(), d), farthest, 6e-5);
    }
  }
}

// No point inside a shape lies beyond its support in any direction.
TEST(Support, BoundsWhatLiesInside) {
  base::Rng rng(4);
  for (const Kind kind : kRound) {
    const Shape shape = Turned(kind);
    int inside = 0;
    for (int i = 0; i < 3000; ++i) {
      const Vector3d p = samples::RandomPoint(0.1, rng);
      if (!Inside(shape, p)) continue;
      ++inside;
      const Vector3d d = samples::RandomPoint(1.0, rng).normalized();
      EXPECT_LE(d.dot(p), Support(shape, base::Pose::Identity(), d) + 1e-12);
    }
    EXPECT_GT(inside, 5) << static_cast<int>(kind);
  }
}

// A shape's support grows by the margin along its own axes, and by at least the margin in any
// direction.
TEST(Grown, ReachesFurtherByTheMargin) {
  base::Rng rng(7);
  const double margin_m = 0.005;
  for (const Kind kind : kRound) {
    const Shape shape = Turned(kind);
    const Shape grown = Grown(shape, margin_m);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(Support(grown, Vector3d::Unit(axis)) - Support(shape, Vector3d::Unit(axis)),
                  margin_m, 1e-12);
    }
    for (int i = 0; i < 100; ++i) {
      const Vector3d d = samples::RandomPoint(1.0, rng).normalized();
      // An ellipsoid with longer axes is only nearly the outer parallel surface of the ellipsoid.
      const double least = kind == Kind::kEllipsoid ? 0.9 * margin_m : margin_m;
      EXPECT_GE(Support(grown, d) - Support(shape, d), least - 1e-12);
    }
  }
}

// Checks points whose distances from the shapes are known.
TEST(Inside, IsRightOnBothSidesOfASurface) {
  const auto inside = [](Kind kind, const Vector3d& p) {
    return Inside(Make(kind, {0.02, 0.03, 0.05}), p);
  };
  EXPECT_TRUE(inside(Kind::kCapsule, {0.0, 0.0, 0.0499}));  // half length plus radius
  EXPECT_FALSE(inside(Kind::kCapsule, {0.0, 0.0, 0.0501}));
  EXPECT_FALSE(inside(Kind::kCapsule, {0.015, 0.0, 0.0449}));
  EXPECT_TRUE(inside(Kind::kCylinder, {0.0199, 0.0, 0.0299}));
  EXPECT_FALSE(inside(Kind::kCylinder, {0.0, 0.0, 0.0301}));
  EXPECT_TRUE(inside(Kind::kBox, {0.0199, 0.0299, 0.0499}));
  EXPECT_FALSE(inside(Kind::kBox, {0.0, 0.0301, 0.0}));
  EXPECT_TRUE(inside(Kind::kEllipsoid, {0.0, 0.0, 0.0499}));
  EXPECT_FALSE(inside(Kind::kEllipsoid, {0.0, 0.0, 0.0501}));
  EXPECT_FALSE(inside(Kind::kEllipsoid, {0.019, 0.015, 0.0}));
}

TEST(Support, OfAMeshIsItsFarthestVertex) {
  Shape mesh = Make(Kind::kMesh, Vector3d::Zero());
  mesh.mesh.vertices = {{0.1, 0.0, 0.0}, {-0.3, 0.2, 0.0}, {0.0, 0.0, 0.4}};
  EXPECT_EQ(Support(mesh, Vector3d::UnitX()), 0.1);
  EXPECT_EQ(Support(mesh, -Vector3d::UnitX()), 0.3);
  EXPECT_EQ(Support(mesh, Vector3d::UnitZ()), 0.4);
}

// It grows about its centroid, not about the origin of its frame.
TEST(Grown, MovesAConvexPieceAwayFromItsMiddle) {
  Shape piece = Make(Kind::kConvex, Vector3d::Zero());
  piece.mesh = Tessellate(Turned(Kind::kBox));
  for (Vector3d& p : piece.mesh.vertices) p += Vector3d(1.0, 0.0, 0.0);
  const Shape grown = Grown(piece, 0.01);
  EXPECT_LT((Centroid(grown.mesh.vertices) - Centroid(piece.mesh.vertices)).norm(), 1e-12);
}

TEST(Grown, MovesVerticesOfConvexPiecesAndLeavesSurfaces) {
  Shape piece = Make(Kind::kConvex, Vector3d::Zero());
  piece.mesh = Tessellate(Turned(Kind::kBox));
  const Shape grown = Grown(piece, 0.01);
  for (std::size_t i = 0; i < grown.mesh.vertices.size(); ++i) {
    EXPECT_NEAR((grown.mesh.vertices[i] - piece.mesh.vertices[i]).norm(), 0.01, 1e-12);
    EXPECT_FALSE(Inside(piece, grown.mesh.vertices[i]));
  }
  piece.kind = Kind::kMesh;
  EXPECT_EQ(Grown(piece, 0.01).mesh.vertices, piece.mesh.vertices);
}

}  // namespace
}  // namespace rangegrasp::geometry
