#include "perception/internal/rotation_axis.h"

#include <gtest/gtest.h>

#include "perception/analytic.h"
#include "perception/internal/axis_refinement.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::Indices;
using testing::Analytic;
using testing::Given;

constexpr double kRadius_m = 0.04;
constexpr double kHeight_m = 0.1;

Vector2d RandomCenter(core::Rng& rng) {
  const double x = rng.Uniform(-0.1, 0.1);
  return {x, rng.Uniform(-0.1, 0.1)};
}

/// A can's lid, and its wall as far round as a sensor sees it (150 deg towards +x).
Analytic Can(const Vector2d& center) {
  Analytic can;
  can.AddDisc({center.x(), center.y(), kHeight_m}, kRadius_m);
  can.AddWall(center, kRadius_m, 0.01, 0.096, core::Deg(-75.0), core::Deg(75.0));
  return can;
}

Indices All(const geometry::PointCloud& cloud) {
  Indices all(cloud.size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

std::optional<RotationAxis> AxisOf(const Given& given, std::uint64_t seed) {
  return given.Describe(All(given.cloud), seed).axis;
}

TEST(FindRotationAxis, IsExactForAnExactCan) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    core::Rng rng(seed);
    const Vector2d center = RandomCenter(rng);
    const Given given(Can(center).cloud);
    const auto axis = AxisOf(given, seed);
    ASSERT_TRUE(axis) << seed;
    EXPECT_NEAR((axis->center_C.head<2>() - center).norm(), 0.0, 1e-9);
    EXPECT_NEAR(axis->center_C.z(), kHeight_m, 1e-9);
    EXPECT_NEAR(axis->radius_m, kRadius_m, 1e-9);
    EXPECT_NEAR(axis->direction_C.z(), 1.0, 1e-12);
    EXPECT_GE(axis->rim_fraction, 0.8);
    EXPECT_EQ(axis->body_fraction, 1.0);
  }
}

TEST(FindRotationAxis, FollowsALeaningCan) {
  const Eigen::AngleAxisd lean(core::Deg(20.0), Vector3d::UnitY());
  auto cloud = Can({0.0, 0.0}).cloud;
  for (Vector3d& p : cloud.points) p = lean * p;
  for (Vector3d& n : cloud.normals) n = lean * n;
  const auto axis = AxisOf(Given(cloud), 1);
  ASSERT_TRUE(axis);
  EXPECT_NEAR((axis->direction_C - lean * Vector3d::UnitZ()).norm(), 0.0, 1e-9);
  EXPECT_NEAR((axis->center_C - lean * Vector3d(0.0, 0.0, kHeight_m)).norm(), 0.0, 1e-9);
}

TEST(FindRotationAxis, RefusesABox) {
  for (const double side : {0.02, 0.03, 0.04}) {
    Analytic box;
    box.AddRectangle({0.0, 0.0, kHeight_m}, {side, 0.0, 0.0}, {0.0, side, 0.0});
    box.AddRectangle({side, 0.0, 0.05}, {0.0, side, 0.0}, {0.0, 0.0, 0.04});
    EXPECT_FALSE(AxisOf(Given(box.cloud), 1)) << side;
  }
}

TEST(FindRotationAxis, RefusesARoundLidOnASquareBody) {
  // The first rule holds, the second does not.
  Analytic shape;
  shape.AddDisc({0.0, 0.0, kHeight_m}, kRadius_m);
  for (const double x : {-kRadius_m, kRadius_m}) {
    shape.AddRectangle({x, 0.0, 0.05}, {0.0, std::copysign(kRadius_m, x), 0.0}, {0.0, 0.0, 0.04});
  }
  EXPECT_FALSE(AxisOf(Given(shape.cloud), 1));
}

TEST(RefineAxis, MovesAnAxisThatTheRimPutWrongBackToTheBody) {
  const Given given(Can({0.0, 0.0}).cloud);
  const auto part = given.Describe(All(given.cloud));
  RotationAxis axis = *part.axis;
  axis.center_C += Vector3d(0.0008, -0.0006, 0.0);
  axis.radius_m -= 0.0007;
  RefineAxis(given.cloud, part.points, *part.top, given.options, axis);
  // Gauss-Newton from 1 mm off 40 mm converges by (1 / 40) a round at the slowest.
  EXPECT_NEAR(axis.center_C.head<2>().norm(), 0.0, 1e-6);
  EXPECT_NEAR(axis.radius_m, kRadius_m, 1e-6);
}

TEST(RefineAxis, LeavesAnAxisThatIsFurtherOffThanARimCanBe) {
  const Given given(Can({0.0, 0.0}).cloud);
  const auto part = given.Describe(All(given.cloud));
  RotationAxis axis = *part.axis;
  axis.center_C += Vector3d(0.006, 0.0, 0.0);
  const RotationAxis before = axis;
  RefineAxis(given.cloud, part.points, *part.top, given.options, axis);
  EXPECT_EQ(axis.center_C, before.center_C);
}

TEST(ArcOf, CountsHowFarRoundPointsGo) {
  for (const double degrees : {30.0, 120.0, 250.0, 360.0}) {
    Analytic arc;
    const Indices points = arc.AddWall({0.01, 0.02}, 0.05, 0.0, 0.002, 0.0, core::Deg(degrees));
    const Circle circle{{0.01, 0.02, 0.0}, Vector3d::UnitZ(), 0.05};
    // Bins of 10 deg: up to one more at either end.
    EXPECT_NEAR(ArcOf(arc.cloud, points, circle), core::Deg(degrees), core::Deg(20.0));
  }
}

}  // namespace
}  // namespace rangegrasp::perception::internal
