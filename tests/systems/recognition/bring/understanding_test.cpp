#include "recognition/bring/understanding.h"

#include <gtest/gtest.h>

namespace rangegrasp::bring {
namespace {

using Eigen::Vector3d;

geometry::TriangleMesh Tetrahedron(double size_m) {
  geometry::TriangleMesh mesh;
  mesh.vertices = {Vector3d::Zero(), size_m * Vector3d::UnitX(), size_m * Vector3d::UnitY(),
                   size_m * Vector3d::UnitZ()};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

// Twenty samples in a row; objects are runs of them.
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

}  // namespace
}  // namespace rangegrasp::bring
