#include "grasp/obstacles.h"

#include <gtest/gtest.h>

#include "geometry/box_scan.h"
#include "geometry/mesh.h"
#include "geometry/sample_meshes.h"

namespace rangegrasp::grasp {
namespace {

using Eigen::Vector3d;

constexpr double kGap_m = 0.004;

geometry::TriangleMesh Box(const Vector3d& low, const Vector3d& high) {
  return geometry::samples::BoxMesh(0.5 * (high - low), 0.5 * (low + high));
}

// The table z = 0 and the target, a box of 40 mm at the origin, seen from above.
class ObstaclesTest : public ::testing::Test {
 protected:
  ObstaclesTest() {
    scene_.sampling.gap_m = kGap_m;
    AddObject({-0.02, -0.02, 0.0}, {0.02, 0.02, 0.04});
  }

  void AddObject(const Vector3d& low, const Vector3d& high) {
    auto& object = scene_.objects.emplace_back();
    object.surface_C = Box(low, high);
    for (double x = low.x(); x <= high.x() + 1e-9; x += kGap_m) {
      for (double y = low.y(); y <= high.y() + 1e-9; y += kGap_m) {
        object.completed_C.emplace_back(x, y, high.z());
        object.points.push_back(static_cast<std::uint32_t>(scene_.source.size()));
        scene_.source.push_back(static_cast<std::uint32_t>(scene_.points_C.size()));
        scene_.points_C.emplace_back(x, y, high.z());
      }
    }
  }
  // Adds `count` points in a row, a gap apart.
  void AddLeftover(const Vector3d& first, int count) {
    for (int i = 0; i < count; ++i) {
      scene_.points_C.push_back(first + Vector3d(0.0, i * kGap_m, 0.0));
    }
  }
  std::vector<geometry::TriangleMesh> Found(const ObstacleOptions& options = {}) const {
    Obstacles obstacles = ObstaclesOf(scene_, 0, {sensor_}, options);
    std::vector<geometry::TriangleMesh> all = std::move(obstacles.measured_C);
    all.insert(all.end(), obstacles.unseen_C.begin(), obstacles.unseen_C.end());
    return all;
  }

  const Vector3d sensor_{0.0, 0.0, 1.0};
  perception::Scene scene_;
};

TEST_F(ObstaclesTest, ATargetAloneHasNone) { EXPECT_TRUE(Found().empty()); }

TEST_F(ObstaclesTest, WhatBelongsToNoObjectIsOne) {
  AddLeftover({0.10, 0.0, 0.02}, 5);
  const auto found = Found();
  ASSERT_EQ(found.size(), 1u);
  for (const Vector3d& v : found[0].vertices) {
    EXPECT_NEAR(v.x(), 0.10, 0.5 * kGap_m + 1e-12);
    EXPECT_GE(v.y(), -0.5 * kGap_m - 1e-12);
    EXPECT_LE(v.y(), 4.5 * kGap_m + 1e-12);
  }
  ObstacleOptions without;
  without.leftovers = false;
  EXPECT_TRUE(Found(without).empty());
}

// As published no leftovers count, but the robot knows its box.
TEST_F(ObstaclesTest, WallsOfTheBoxAreAlsoWithoutLeftovers) {
  for (int i = 0; i < 40; ++i) {
    for (int k = 0; k < 20; ++k) {
      scene_.container.push_back(static_cast<std::uint32_t>(scene_.cloud.size()));
      scene_.cloud.points.emplace_back(0.15, i * kGap_m, k * kGap_m);
      scene_.cloud.normals.emplace_back(-1.0, 0.0, 0.0);
    }
  }
  ObstacleOptions without;
  without.leftovers = false;
  for (const double gap_m : {kGap_m, 0.0}) {  // 0: lengths are not adapted
    scene_.sampling.gap_m = gap_m;
    const auto found = Found(without);
    ASSERT_EQ(found.size(), 1u) << gap_m;
    for (const Vector3d& v : found[0].vertices) EXPECT_NEAR(v.x(), 0.15, 0.5 * kGap_m + 1e-3);
  }
}

// Two walls of 200 mm form a corner; the space in the corner stays free.
TEST_F(ObstaclesTest, AThingThatIsNotConvexLeavesRoomInItsBend) {
  AddLeftover({0.30, 0.0, 0.02}, 50);
  for (int i = 1; i < 50; ++i) scene_.points_C.emplace_back(0.30 + i * kGap_m, 0.0, 0.02);
  const auto found = Found();
  ASSERT_EQ(found.size(), 1u);
  for (const Vector3d& v : found[0].vertices) {
    EXPECT_TRUE(std::abs(v.x() - 0.30) < kGap_m || std::abs(v.y()) < kGap_m) << v.transpose();
  }
}

TEST_F(ObstaclesTest, WhatTheTargetLeansOnIsNotTheTargetsIfItIsLarger) {
  AddLeftover({0.02 + 2.5 * kGap_m, 0.0, 0.04}, 30);
  EXPECT_EQ(Found().size(), 1u);
}

TEST_F(ObstaclesTest, PointsOfTheTableAreNone) {
  AddLeftover({0.10, 0.0, 0.02}, 5);
  for (std::uint32_t i = 0; i < 5; ++i) {
    scene_.table.points.push_back(static_cast<std::uint32_t>(scene_.points_C.size() - 5 + i));
  }
  EXPECT_TRUE(Found().empty());
}

TEST_F(ObstaclesTest, OneOrTwoPointsAreNoise) {
  AddLeftover({0.10, 0.0, 0.02}, 2);
  EXPECT_TRUE(Found().empty());
}

TEST_F(ObstaclesTest, WhatHangsOnTheTargetIsTheTargets) {
  AddLeftover({0.02 + 2.5 * kGap_m, 0.0, 0.04}, 5);
  EXPECT_TRUE(Found().empty());
}

// The points are on the sensor's line of sight through the target's edge, and far below it.
TEST_F(ObstaclesTest, PointsBesideAnEdgeInTheImageAreMixed) {
  const Vector3d edge(0.021, 0.0, 0.04);
  scene_.objects[0].completed_C.clear();  // so that the points are not attached to it
  for (const double share : {1.005, 1.010, 1.015, 1.020}) {
    scene_.points_C.push_back(sensor_ + share * (edge - sensor_));
  }
  EXPECT_TRUE(Found().empty());
}

// An object of 40 mm height next to the target, seen at an angle. Its shadow extends
// 0.04 * 0.2 / 0.96 m beyond its edge, away from the sensor, and down to the table.
TEST_F(ObstaclesTest, BehindAnotherObjectNothingIsKnown) {
  AddObject({0.20, -0.02, 0.0}, {0.24, 0.02, 0.04});
  const auto found = Found();
  ASSERT_EQ(found.size(), 1u);
  double furthest = 0.0;
  double lowest = 1.0;
  for (const Vector3d& v : found[0].vertices) {
    furthest = std::max(furthest, v.x());
    lowest = std::min(lowest, v.z());
  }
  EXPECT_NEAR(furthest, 0.24 + 0.04 * 0.24 / 0.96, 1e-9);
  EXPECT_NEAR(lowest, 0.0, 1e-9);
  ObstacleOptions without;
  without.unseen = false;
  EXPECT_TRUE(Found(without).empty());
}

using Eigen::AlignedBox3d;
using geometry::samples::LookFrom;
using geometry::samples::ScanBox;

constexpr double kCell_m = 0.01;
const AlignedBox3d kScannedBox(Vector3d(-0.03, -0.03, 0.0), Vector3d(0.03, 0.03, 0.12));

geometry::Observation SeenFrom(const std::vector<Vector3d>& places_C) {
  base::Rng rng(1);
  geometry::Observation observation;
  for (const Vector3d& place_C : places_C) {
    observation.views.push_back(ScanBox(LookFrom(place_C, {0.0, 0.0, 0.0}), kScannedBox, 0.0, rng));
  }
  return observation;
}

// The space behind the box, seen from the sensor at +x.
const AlignedBox3d kBehind(Vector3d(-0.09, -0.03, 0.0), Vector3d(-0.04, 0.03, 0.06));

geometry::TriangleMesh UnseenBehindFrom(const std::vector<Vector3d>& places_C) {
  const std::vector<geometry::TriangleMesh> shadows = {Box(kBehind.min(), kBehind.max())};
  return UnseenByAll(SeenFrom(places_C), shadows, kCell_m);
}

TEST(UnseenByAll, OneViewsShadowStays) {
  const auto unseen = UnseenBehindFrom({{0.5, 0.0, 0.5}});
  // At 45 deg the shadow is as long as the box is high. All of kBehind is unseen, except at most
  // one cell on each side that its bounds cut.
  EXPECT_GT(geometry::Volume(unseen), 0.03 * 0.04 * 0.05);
  EXPECT_LE(geometry::Volume(unseen), kBehind.volume() + 1e-9);
  const Vector3d rounding = Vector3d::Constant(1e-9);
  EXPECT_TRUE(AlignedBox3d(kBehind.min() - rounding, kBehind.max() + rounding)
                  .contains(geometry::BoundsOf(unseen.vertices)));
}

TEST(UnseenByAll, WhatAnotherViewLooksIntoIsSeen) {
  const auto unseen = UnseenBehindFrom({{0.5, 0.0, 0.5}, {-0.5, 0.0, 0.5}});
  // Only the table's own cells are left; they are a surface.
  EXPECT_LT(geometry::Volume(unseen), 0.02 * kBehind.volume());
}

TEST(UnseenByAll, WhatNoShadowHoldsDoesNotCount) {
  EXPECT_TRUE(UnseenByAll(SeenFrom({{0.5, 0.0, 0.5}}), {}, kCell_m).triangles.empty());
}

}  // namespace
}  // namespace rangegrasp::grasp
