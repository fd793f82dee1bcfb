#include "cylinders/visibility.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "base/rng.h"
#include "cylinders/tabletop_scan.h"
#include "geometry/random_points.h"

namespace rangegrasp::cylinders {
namespace {

using Eigen::Vector3d;
using geometry::samples::RandomVector;

bool IsInside(const Cylinder& c, const Vector3d& p) {
  const double along = (p - c.center).dot(c.axis);
  return std::abs(along) < 0.5 * c.height_m && (p - c.center - along * c.axis).norm() < c.radius_m;
}

TEST(Visibility, EntryIsWhereStepsAlongTheRayFirstAreInside) {
  base::Rng rng(1);
  int hits = 0;
  for (int i = 0; i < 400; ++i) {
    const Cylinder c{0.1 * RandomVector(rng), RandomVector(rng).normalized(), 0.2, 0.5};
    const Vector3d origin = 2.0 * RandomVector(rng).normalized();
    const Vector3d target = origin + 2.0 * (0.2 * RandomVector(rng) - origin);
    std::optional<double> stepped;
    constexpr int kSteps = 4000;
    for (int k = 0; k < kSteps && !stepped; ++k) {
      const double share = 1.2 * k / kSteps;
      if (IsInside(c, origin + share * (target - origin))) stepped = share;
    }
    const auto entry = EntryOf(origin, target, c);
    if (stepped) {
      ASSERT_TRUE(entry) << i;
      EXPECT_NEAR(entry->share, *stepped, 1.2 / kSteps + 1e-9) << i;
      const Vector3d at = origin + entry->share * (target - origin);
      const double along = std::abs((at - c.center).dot(c.axis));
      EXPECT_EQ(entry->by_end, along > 0.5 * c.height_m - 1e-9) << i;
      ++hits;
    }
  }
  EXPECT_GT(hits, 100);
}

TEST(Visibility, RayAlongTheAxisEntersByTheEnd) {
  const Cylinder c{{0, 0, 0}, Vector3d::UnitZ(), 0.03, 0.1};
  const auto entry = EntryOf({0, 0, 1}, {0, 0, 0}, c);
  ASSERT_TRUE(entry);
  EXPECT_NEAR(entry->share, 0.95, 1e-12);
  EXPECT_TRUE(entry->by_end);
  EXPECT_FALSE(EntryOf({0.1, 0, 1}, {0.1, 0, 0}, c));
  EXPECT_FALSE(EntryOf({1, 0, 0.2}, {0, 0, 0.2}, c));
}

class SceneWithOneCylinder : public testing::Test {
 protected:
  ViewCounts Compare(const Cylinder& cylinder) {
    return CompareWithView(image_.points_C, image_.origins_C,
                           geometry::Indices(image_.points_C.size(), 0), cylinder, 0.003);
  }

  base::Rng rng_{3};
  Cylinder there_ = testing_support::Standing(0.0, 0.0, 0.0257, 0.15);
  geometry::RangeImage image_ = testing_support::Scan({{there_}, {}}, {}, rng_).views.front().image;
};

TEST_F(SceneWithOneCylinder, AgreesWithItselfAndNotWithOthers) {
  EXPECT_GT(Compare(there_).Agreement(), 0.97);
  EXPECT_EQ(Compare(there_).before, 0u);
  EXPECT_LT(Compare(testing_support::Standing(0.0, 0.1, 0.0257, 0.15)).Agreement(), 0.3);
  EXPECT_LT(Compare(testing_support::Standing(0.0, 0.0, 0.0257, 0.22)).Agreement(), 0.85);
  // One that would stand behind it is hidden in part.
  EXPECT_GT(Compare(testing_support::Standing(-0.06, 0.0, 0.0257, 0.15)).before, 200u);
}

TEST_F(SceneWithOneCylinder, PointsOnItAreThoseNearItsSurface) {
  const auto on = PointsOn(image_.points_C, there_, 0.002);
  std::size_t high = 0;
  for (std::size_t i = 0; i < on.size(); ++i) {
    const Vector3d& p = image_.points_C[i];
    if (p.z() < 0.01) continue;
    EXPECT_TRUE(on[i]) << p.transpose();
    ++high;
  }
  EXPECT_GT(high, 500u);
}

TEST(Visibility, WhatIsSeenInsideAnOpenCylinderSaysNothing) {
  // A point inside, seen through the top, and one seen through the barrel.
  const Cylinder c{{0, 0, 0.05}, Vector3d::UnitZ(), 0.03, 0.1};
  const geometry::Points place = {{0, 0, 1}, {1, 0, 0.05}};
  const geometry::Points points = {{0, 0, 0.05}, {0, 0, 0.05}};
  const auto counts = CompareWithView(points, place, geometry::Indices{0, 1}, c, 0.002);
  EXPECT_EQ(counts.through, 1u);
  EXPECT_EQ(counts.on, 0u);
}

}  // namespace
}  // namespace rangegrasp::cylinders
