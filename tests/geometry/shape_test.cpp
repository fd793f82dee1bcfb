#include "geometry/shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/units.h"
#include "geometry/random_points.h"

namespace rangegrasp::geometry {
namespace {

using base::kPi;

/// Every edge has one triangle on each side.
bool IsClosed(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  }
  return std::all_of(edges.begin(), edges.end(), [&edges](const auto& edge) {
    const auto reverse = edges.find({edge.first.second, edge.first.first});
    return edge.second == 1 && reverse != edges.end();
  });
}

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
    EXPECT_TRUE(IsClosed(mesh));
    // With steps of h = 2 pi / n an inscribed circle loses h^2 / 6 of its area, a profile of chords
    // h^2 / 4 of a sphere's volume: 5 / 12 together, and a little for higher orders.
    EXPECT_LE(Volume(mesh), volume * (1.0 + 1e-12));
    EXPECT_GE(Volume(mesh), volume * (1.0 - 0.43 * std::pow(2.0 * kPi / 128.0, 2)));
    EXPECT_TRUE(IsClosed(Tessellate(shape, 3)));
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

}  // namespace
}  // namespace rangegrasp::geometry
