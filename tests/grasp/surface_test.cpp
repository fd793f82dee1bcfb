#include "grasp/surface.h"

#include <gtest/gtest.h>

#include "grasp/fixtures.h"

namespace rangegrasp::grasp {
namespace {

using namespace test;

TEST(SampleSurface, SharesTheSamplesByArea) {
  const auto mesh = Extrude(Rectangle(0.1, 0.05), 0.02);
  const double area = 2 * (0.1 * 0.05 + 0.1 * 0.02 + 0.05 * 0.02);
  const auto samples = SampleSurface(mesh, 5000);
  EXPECT_NEAR(static_cast<double>(samples.points.size()), 5000.0, 1.0);
  EXPECT_NEAR(samples.area_m2, area / 5000, 1e-12);
  int top = 0;
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    top += samples.normals[i].z() > 0.5 ? 1 : 0;
    EXPECT_LE(std::abs(samples.points[i].x()), 0.05 + 1e-12);
  }
  EXPECT_NEAR(top, 5000 * 0.005 / area, 2.0);
}

TEST(SampleSurface, MovesWithTheMesh) {
  const auto mesh = Extrude(Disc(0.04), 0.1);
  const base::Pose X = At(0.1, -0.2, 0.7);
  const auto here = SampleSurface(mesh, 500);
  const auto there = SampleSurface(geometry::Transformed(mesh, X), 500);
  ASSERT_EQ(here.points.size(), there.points.size());
  for (std::size_t i = 0; i < here.points.size(); ++i) {
    EXPECT_LT((X * here.points[i] - there.points[i]).norm(), 1e-9);
  }
}

TEST(CenterOfMass, OfAHalfCylinderIsFourRadiiOverThreePiAboveItsFlatSide) {
  const double radius = 0.04;
  const auto mesh = Lay(Extrude(HalfDisc(radius, 200), 0.17), 0.17, 0.0);
  const auto com = CenterOfMass(mesh, SampleSurface(mesh, 3000).points);
  // With 199 chords of 0.9 deg, the area, and so the centre, is right within 1e-4 of the radius.
  EXPECT_NEAR(com.z(), 4.0 * radius / (3.0 * base::kPi), 2e-5);
  EXPECT_NEAR(com.head<2>().norm(), 0.0, 1e-4);
}

TEST(CenterOfMass, OfAnOpenSurfaceIsTheMeanOfItsSamples) {
  geometry::TriangleMesh sheet;
  sheet.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}, {0, 0.1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const auto com = CenterOfMass(sheet, SampleSurface(sheet, 4000).points);
  EXPECT_LT((com - Vector3d(0.05, 0.05, 0.0)).norm(), 5e-4);
}

// A box of 100 x 60 x 40 mm that is turned by 0.5 rad; its corners are among the points.
TEST(ObjectOfPoints, HasABoxThatIsTurnedWithIt) {
  SceneBuilder builder;
  builder.AddBox({0.1, 0.06, 0.04}, At(0.2, -0.1, 0.5));
  const perception::Scene& scene = builder.scene;
  const auto object = ObjectOfPoints(scene, scene.objects[0].points);
  EXPECT_LT((object.size_m - Vector3d(0.1, 0.06, 0.04)).norm(), 1e-9);
  EXPECT_LT((object.center_C - Vector3d(0.2, -0.1, 0.02)).norm(), 1e-9);
  EXPECT_NEAR(object.height_m, 0.04, 1e-12);
  EXPECT_NEAR(std::abs(object.axis_C.dot(Vector3d(std::cos(0.5), std::sin(0.5), 0.0))), 1.0, 1e-9);
}

}  // namespace
}  // namespace rangegrasp::grasp
