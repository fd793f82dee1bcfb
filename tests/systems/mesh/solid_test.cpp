#include "mesh/solid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "base/units.h"
#include "error_of.h"
#include "geometry/mesh.h"
#include "geometry/random_points.h"
#include "geometry/sample_meshes.h"
#include "geometry/shape.h"

namespace rangegrasp::geometry {
namespace {

using samples::BoxMesh;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TriangleMesh RepairBall(double radius, const Eigen::Vector3d& center = {0, 0, 0}) {
  Shape ball;
  ball.size.setConstant(radius);
  ball.X_BS.translation() = center;
  return Tessellate(ball, 32);
}

std::string Complaint(const TriangleMesh& mesh) {
  return testing_support::ErrorOf([&] { RepairMesh(mesh); });
}

TEST(Repair, ASolidStaysAsItIs) {
  const Repaired repaired = RepairMesh(BoxMesh({1, 2, 3}));
  EXPECT_NEAR(Volume(repaired.mesh), 48.0, 1e-9);
  EXPECT_EQ(repaired.mesh.triangles.size(), 12U);
  EXPECT_THAT(repaired.done, IsEmpty());
}

// As in STL, each triangle has its own vertices.
TEST(Repair, JoinsLooseTriangles) {
  const TriangleMesh box = BoxMesh({1, 2, 3});
  TriangleMesh loose;
  for (const auto& triangle : box.triangles) {
    const auto first = static_cast<std::uint32_t>(loose.vertices.size());
    for (const std::uint32_t corner : triangle) loose.vertices.push_back(box.vertices[corner]);
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  const Repaired repaired = RepairMesh(loose);
  EXPECT_EQ(repaired.mesh.vertices.size(), 8U);
  EXPECT_NEAR(Volume(repaired.mesh), 48.0, 1e-9);
}

TEST(Repair, TurnsFacesThatPointInward) {
  TriangleMesh box = BoxMesh({1, 2, 3});
  for (auto& t : box.triangles) std::swap(t[0], t[1]);
  const Repaired all = RepairMesh(box);
  EXPECT_NEAR(Volume(all.mesh), 48.0, 1e-9);
  EXPECT_TRUE(all.turned_inside_out);
  TriangleMesh one = BoxMesh({1, 2, 3});
  std::swap(one.triangles[5][0], one.triangles[5][1]);
  EXPECT_NEAR(Volume(RepairMesh(one).mesh), 48.0, 1e-9);
}

TEST(Repair, ClosesASmallHole) {
  TriangleMesh ball = RepairBall(1.0);
  const double whole = Volume(ball);
  ball.triangles.erase(ball.triangles.begin() + 300);
  const Repaired repaired = RepairMesh(ball);
  EXPECT_NEAR(Volume(repaired.mesh), whole, 0.01 * whole);
  EXPECT_THAT(repaired.done, Contains(HasSubstr("hole")));
}

// A vertex on an edge that the neighbor lacks, with a triangle without area between them: removing
// it leaves a hole that no triangle with an area can close.
TEST(Repair, ClosesWhatATriangleWithoutAreaHadClosed) {
  TriangleMesh box = BoxMesh({1, 2, 3});
  const auto [a, b, c] = box.triangles.front();
  const auto middle = static_cast<std::uint32_t>(box.vertices.size());
  box.vertices.push_back(0.5 * (box.vertices[a] + box.vertices[b]));
  box.triangles.front() = {a, middle, c};
  box.triangles.push_back({middle, b, c});
  box.triangles.push_back({a, b, middle});
  const Repaired repaired = RepairMesh(box);
  EXPECT_THAT(repaired.done, Contains(HasSubstr("without area")));
  // The wrap is offset from 88 of surface by 0.18 % of the diagonal.
  EXPECT_NEAR(Volume(repaired.mesh), 48.0 + 88.0 * 0.0018 * std::sqrt(56.0), 0.1);
}

// A cup made of one sheet: its mouth is not a hole to close.
TEST(Repair, RefusesALargeHoleUnlessTold) {
  TriangleMesh box = BoxMesh({1, 1, 1});
  std::erase_if(box.triangles, [&](const auto& t) {
    return box.vertices[t[0]].z() > 0 && box.vertices[t[1]].z() > 0 && box.vertices[t[2]].z() > 0;
  });
  EXPECT_THAT(Complaint(box), HasSubstr("is open"));
  EXPECT_NEAR(Volume(RepairMesh(box, 1.0).mesh), 8.0, 1e-9);
}

// Two boxes that overlap by about half: 12 of volume, while the sum of both would be 16.
TEST(Repair, WrapsWhatCrossesItself) {
  TriangleMesh both = BoxMesh({1, 1, 1});
  Append(BoxMesh({1, 1, 1}, {1, 0.1, 0.1}), both);
  const Repaired repaired = RepairMesh(both);
  EXPECT_THAT(repaired.done, Contains(HasSubstr("intersects itself")));
  // The overlap is 1 x 1.9 x 1.9; the wrap is offset by 0.2 % of the size on all sides.
  EXPECT_NEAR(Volume(repaired.mesh), 16.0 - 3.61, 0.06 * 12.39);
}

TEST(Repair, RefusesASheetAndWhatHasNoArea) {
  // The same triangle from both sides: closed, but without volume.
  TriangleMesh sheet;
  sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 1}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_NE(Complaint(sheet), "");
  EXPECT_THAT(Complaint(BoxMesh({1, 1, 1e-7})), HasSubstr("no volume"));
  TriangleMesh line;
  line.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  line.triangles = {{0, 1, 2}};
  EXPECT_THAT(Complaint(line), HasSubstr("no triangle with an area"));
  TriangleMesh one;
  one.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  one.triangles = {{0, 1, 2}};
  EXPECT_THAT(Complaint(one), HasSubstr("is open"));
}

TEST(AlphaWrap, MakesASlabOfASheetWithAGap) {
  // Two squares next to each other, 0.05 apart.
  TriangleMesh sheet;
  for (const double x : {-1.025, -0.025, 0.025, 1.025}) {
    sheet.vertices.emplace_back(x, 0.0, 0.0);
    sheet.vertices.emplace_back(x, 1.0, 0.0);
  }
  sheet.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 6, 7}, {4, 7, 5}};
  const double offset = 0.05;
  const TriangleMesh slab = AlphaWrap(sheet, 0.03, offset);
  EXPECT_THAT(RepairMesh(slab).done, IsEmpty());  // closed, oriented outwards, in one piece
  // Both sides, and half a tube along a border of 6.1. With balls of 0.03, faces lie up to 0.01
  // inside the tube, which is a third of it.
  const double sides = 2.0 * offset * 2.05;
  const double border = 6.1 * 0.5 * base::kPi * offset * offset;
  EXPECT_LE(Volume(slab), sides + border);
  EXPECT_GE(Volume(slab), sides + 0.67 * border);
}

TEST(AlphaWrap, ABallHasNoInnerSide) {
  const double offset = 0.05;
  const TriangleMesh wrap = AlphaWrap(RepairBall(1.0), 0.2, offset);
  // The ball's edges are up to 0.2 long, so that faces lie up to 0.2^2 / 4 inside the ball.
  for (const Eigen::Vector3d& p : wrap.vertices) EXPECT_NEAR(p.norm(), 1.0 + offset, 0.01);
}

TEST(Simplified, KeepsShapeWithFewerTriangles) {
  const TriangleMesh ball = RepairBall(1.0);
  const TriangleMesh coarse = Simplified(ball, 300);
  EXPECT_LE(coarse.triangles.size(), 300U);
  EXPECT_NEAR(Volume(coarse), Volume(ball), 0.03 * Volume(ball));
}

TEST(OverlapOf, IsOneForTheSolidItselfAndHalfForAHalf) {
  const TriangleMesh box = BoxMesh({1, 1, 1});
  EXPECT_DOUBLE_EQ(OverlapOf(box, {box}).covered, 1.0);
  EXPECT_DOUBLE_EQ(OverlapOf(box, {box}).beyond, 0.0);
  const Overlap half = OverlapOf(box, {BoxMesh({1, 1, 1}, {1, 0, 0})});
  EXPECT_NEAR(half.covered, 0.5, 0.03);
  EXPECT_NEAR(half.beyond, 0.5, 0.03);
}

// m (b^2 + c^2) / 12. About the center, there is no parallel-axis shift.
TEST(MassProperties, AreThoseOfABoxWhereverItStands) {
  const MassProperties box = MassPropertiesOf(BoxMesh({1, 2, 3}, {10, -20, 30}));
  EXPECT_NEAR(box.volume_m3, 48.0, 1e-9);
  EXPECT_TRUE(box.center_M.isApprox(Eigen::Vector3d(10, -20, 30), 1e-12));
  EXPECT_NEAR(box.inertia_M(0, 0), 48.0 * (16 + 36) / 12, 1e-8);
  EXPECT_NEAR(box.inertia_M(1, 1), 48.0 * (4 + 36) / 12, 1e-8);
  EXPECT_NEAR(box.inertia_M(2, 2), 48.0 * (4 + 16) / 12, 1e-8);
  EXPECT_NEAR(box.inertia_M(0, 1), 0.0, 1e-8);
}

// A tetrahedron at the origin has products of inertia: -V a b / 20 + shift.
TEST(MassProperties, HaveTheProductsOfATetrahedron) {
  TriangleMesh tetrahedron;
  tetrahedron.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  tetrahedron.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const MassProperties m = MassPropertiesOf(tetrahedron);
  EXPECT_NEAR(m.volume_m3, 1.0 / 6, 1e-15);
  EXPECT_TRUE(m.center_M.isApprox(Eigen::Vector3d::Constant(0.25), 1e-12));
  // int xy dV = 1 / 120 about the corner, minus V x y of the center.
  EXPECT_NEAR(m.inertia_M(0, 1), -(1.0 / 120 - 1.0 / 96), 1e-15);
  EXPECT_NEAR(m.inertia_M(0, 0), 2 * (1.0 / 60 - 1.0 / 96), 1e-15);
}

using samples::RandomDirection;

constexpr double kRadius_m = 0.05;

/// Random points on a ball's surface, about 2 mm apart.
PointCloud Ball(std::uint64_t seed) {
  base::Rng rng(seed);
  PointCloud cloud;
  for (int i = 0; i < 8000; ++i) {
    cloud.normals.push_back(RandomDirection(rng));
    cloud.points.push_back(Eigen::Vector3d(0.3, -0.2, 0.1) + kRadius_m * cloud.normals.back());
  }
  return cloud;
}

TEST(PoissonSurface, OfABallIsItAndClosed) {
  const auto mesh = PoissonSurface(Ball(1), 0.002);
  ASSERT_TRUE(mesh);
  EXPECT_TRUE(samples::IsClosed(*mesh));
  // Flat triangles on a ball of radius r with sagitta s lie inside it by 2 s / 3 on average; a
  // quarter of the spacing is 1 % of r.
  const double ball_m3 = 4.0 / 3.0 * std::numbers::pi * std::pow(kRadius_m, 3);
  EXPECT_NEAR(Volume(*mesh) / ball_m3, 1.0, 0.02);
  for (const Eigen::Vector3d& v : mesh->vertices) {
    EXPECT_NEAR((v - Eigen::Vector3d(0.3, -0.2, 0.1)).norm(), kRadius_m, 0.0005);
  }
}

TEST(PoissonSurface, ClosesWhatIsOpen) {
  PointCloud bowl;
  const PointCloud ball = Ball(2);
  for (std::size_t i = 0; i < ball.size(); ++i) {
    if (ball.normals[i].z() > 0.8) continue;
    bowl.points.push_back(ball.points[i]);
    bowl.normals.push_back(ball.normals[i]);
  }
  const auto mesh = PoissonSurface(bowl, 0.002);
  ASSERT_TRUE(mesh);
  EXPECT_TRUE(samples::IsClosed(*mesh));
}

TEST(PoissonSurface, TheSamePointsGiveTheSameTrianglesWhereverTheHeapLies) {
  const auto first = PoissonSurface(Ball(3), 0.002);
  std::vector<std::vector<char>> held;  // blocks of the sizes that the mesher asks for
  for (std::size_t i = 0; i < 200; ++i) held.emplace_back(1000 * (i % 60 + 1));
  for (std::size_t i = 0; i < held.size(); i += 3) std::vector<char>().swap(held[i]);
  const auto second = PoissonSurface(Ball(3), 0.002);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->vertices, second->vertices);
  EXPECT_EQ(first->triangles, second->triangles);
}

// 30 balls of 20 mm in a cubic metre, 10 points each. The mesher starts with points of which no
// three are near enough for a facet (CGAL 5.5; one of some hundred draws).
TEST(PoissonSurface, OfPointsOfManyThingsFarApartThereIsNone) {
  base::Rng rng(50);
  PointCloud cloud;
  for (int ball = 0; ball < 30; ++ball) {
    const Eigen::Vector3d center = samples::RandomInUnitCube(rng).reverse();
    for (int i = 0; i < 10; ++i) {
      cloud.normals.push_back(RandomDirection(rng));
      cloud.points.push_back(center + 0.02 * cloud.normals.back());
    }
  }
  EXPECT_FALSE(PoissonSurface(cloud, 0.01));
}

TEST(PoissonSurface, RefusesWhatIsNoOrientedCloud) {
  PointCloud ball = Ball(4);
  ball.normals.pop_back();
  EXPECT_THROW(PoissonSurface(ball, 0.002), std::invalid_argument);
  EXPECT_THROW(PoissonSurface({}, 0.002), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::geometry
