#include "recognition/bring/understanding.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/box_scan.h"
#include "perception/raster_scan.h"

namespace rangegrasp::bring {
namespace {

using Eigen::Vector3d;
using geometry::samples::LookFrom;
using geometry::samples::ScanBox;

geometry::TriangleMesh Tetrahedron(double size_m) {
  geometry::TriangleMesh mesh;
  mesh.vertices = {Vector3d::Zero(), size_m * Vector3d::UnitX(), size_m * Vector3d::UnitY(),
                   size_m * Vector3d::UnitZ()};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

// Twenty samples in a row; each object is a range of them.
perception::Scene SceneOf(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& runs) {
  perception::Scene scene;
  for (std::uint32_t i = 0; i < 20; ++i) {
    const Vector3d p(0.01 * i, 0.0, 0.05);
    scene.points_C.push_back(p);
    scene.samples.push_back({0, i});
    scene.cloud.points.push_back(p);
    scene.source.push_back(i);
  }
  for (const auto& [first, last] : runs) {
    perception::PerceivedObject object;
    for (std::uint32_t i = first; i < last; ++i) object.points.push_back(i);
    object.center_C = Vector3d(first, 0.0, 0.0);
    scene.objects.push_back(object);
  }
  return scene;
}

recognition::FoundObject Found(std::uint32_t first, std::uint32_t last) {
  recognition::FoundObject found;
  found.object = "thing";
  found.X_CB.translation() = Vector3d(0.1, 0.2, 0.3);
  for (std::uint32_t i = first; i < last; ++i) found.samples.push_back({0, i});
  return found;
}

Understanding With(const perception::Scene& scene, const recognition::FoundObject& found) {
  Understanding understanding{scene, {}};
  understanding.found.resize(scene.objects.size());
  PutKnown(found, Tetrahedron(0.1), understanding);
  return understanding;
}

TEST(PutKnown, TakesThePlaceOfWhatWasPerceivedOfIt) {
  const auto known = With(SceneOf({{0, 5}, {5, 15}, {15, 20}}), Found(5, 15));
  ASSERT_EQ(known.scene.objects.size(), 3u);
  ASSERT_TRUE(known.found[1]);
  EXPECT_FALSE(known.found[0] || known.found[2]);
  EXPECT_EQ(known.scene.objects[1].points.size(), 10u);
  EXPECT_EQ(known.scene.objects[1].surface_C.vertices.front(), Vector3d(0.1, 0.2, 0.3));
  EXPECT_NEAR(known.scene.objects[1].base_m, 0.3, 1e-12);
  EXPECT_NEAR(known.scene.objects[1].height_m, 0.4, 1e-12);
  EXPECT_EQ(known.Find("thing"), 1u);
  EXPECT_EQ(known.Find("another"), std::nullopt);
}

TEST(PutKnown, PiecesOfItBecomeOneAndNeighborsStay) {
  const auto known = With(SceneOf({{0, 4}, {4, 9}, {9, 20}}), Found(0, 11));
  ASSERT_EQ(known.scene.objects.size(), 2u);
  EXPECT_TRUE(known.found[0]);
  EXPECT_EQ(known.scene.objects[0].points.size(), 11u);
  EXPECT_EQ(known.scene.objects[1].center_C.x(), 9.0);
}

TEST(PutKnown, WhatWasNotPerceivedAtAllIsAddedLast) {
  const auto known = With(SceneOf({{0, 5}}), Found(10, 20));
  ASSERT_EQ(known.scene.objects.size(), 2u);
  EXPECT_FALSE(known.found[0]);
  EXPECT_TRUE(known.found[1]);
}

recognition::Library Shelf() {
  return recognition::Library(
      {recognition::MakeKnownObject("box", "Box", synthetic::BoxMesh(0.08, 0.10, 0.12))});
}

// Views of the box in the middle, from one side or from all four.
geometry::Observation LookFromSides(int sides) {
  const Eigen::AlignedBox3d box(Vector3d(-0.04, -0.05, 0.0), Vector3d(0.04, 0.05, 0.12));
  base::Rng rng(3);
  geometry::Observation observation;
  for (int side = 0; side < sides; ++side) {
    const double angle = 1.5707963 * side + 0.4;
    const Vector3d from(0.7 * std::cos(angle), 0.7 * std::sin(angle), 0.6);
    observation.views.push_back(ScanBox(LookFrom(from, Vector3d::Zero()), box, 0.0005, rng, 200));
  }
  return observation;
}

Understanding Knowing(bool known) {
  Understanding understanding;
  understanding.found.resize(1);
  if (!known) return understanding;
  recognition::FoundObject found;
  found.object = "box";
  found.X_CB.translation() = Vector3d(0.0, 0.0, 0.06);
  understanding.found.front() = found;
  return understanding;
}

TEST(HidingArea, IsBehindAnObjectUntilItIsSeenFromAllSides) {
  const auto library = Shelf();
  const auto area = [&](int sides, bool known) {
    return HidingArea(LookFromSides(sides), Knowing(known), library, Vector3d::Zero(), 0.16);
  };
  EXPECT_GT(area(1, true), 0.5 * 0.08 * 0.10) << "as large as the box, at this slant";
  EXPECT_LT(area(4, true), 0.001);
  // The inside of an unknown object may be anything.
  EXPECT_GT(area(4, false), 0.5 * 0.08 * 0.10);
}

TEST(HidingArea, OfAnEmptyTableIsNone) {
  const Eigen::AlignedBox3d nothing(Vector3d(5.0, 5.0, 0.0), Vector3d(5.1, 5.1, 0.1));
  base::Rng rng(3);
  geometry::Observation observation;
  observation.views.push_back(
      ScanBox(LookFrom(Vector3d(0.5, 0.0, 0.7), Vector3d::Zero()), nothing, 0.0005, rng, 200));
  EXPECT_EQ(HidingArea(observation, {}, Shelf(), Vector3d::Zero(), 0.12), 0.0);
}

TEST(SmallestFootprint, IsThatOfTheBoxOnItsSmallestFace) {
  EXPECT_NEAR(SmallestFootprint(Shelf().Find("box")), 0.08 * 0.10, 1e-9);
}

}  // namespace
}  // namespace rangegrasp::bring
