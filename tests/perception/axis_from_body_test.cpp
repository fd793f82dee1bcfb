#include "perception/internal/axis_from_body.h"

#include <gtest/gtest.h>

#include "perception/analytic.h"

namespace rangegrasp::perception::internal {
namespace {

using geometry::Indices;
using samples::Analytic;
using samples::Given;

constexpr double kRadius_m = 0.04;

/// A cup about (0.02, -0.03): its lip, the near side of its wall from outside, the far from inside.
Indices AddCup(Analytic& shape, double wall_m) {
  const Eigen::Vector2d center(0.02, -0.03);
  const auto lip = shape.AddDisc({0.02, -0.03, 0.1}, kRadius_m, kRadius_m - wall_m);
  const auto outside =
      shape.AddWall(center, kRadius_m, 0.01, 0.096, base::Deg(-75.0), base::Deg(75.0));
  const auto inside = shape.AddWall(center, kRadius_m - wall_m, 0.05, 0.096, base::Deg(105.0),
                                    base::Deg(255.0), true);
  return samples::Joined(samples::Joined(lip, outside), inside);
}

TEST(AxisFromBody, IsExactForAnExactWallWhateverTheDraws) {
  Analytic cup;
  const Indices points = AddCup(cup, 0.004);
  const Given given(cup.cloud);
  const Part part = given.Describe(points);
  ASSERT_TRUE(part.top);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    base::Rng rng(seed);
    const auto axis =
        AxisFromBody(cup.cloud, part.points, *part.top, given.table, given.options, rng);
    ASSERT_TRUE(axis);
    EXPECT_NEAR((axis->center_C - Eigen::Vector3d(0.02, -0.03, 0.1)).norm(), 0.0, 1e-9);
    EXPECT_NEAR(axis->radius_m, kRadius_m, 1e-9);
    EXPECT_EQ(axis->direction_C, Eigen::Vector3d::UnitZ());
  }
}

// Not of the wall: the inside of a wall of 1.5 mm, a handle, points 1.5 mm off whose normals do not
// pass the axis, and the rounding of the lip.
TEST(AxisFromBody, TakesWhatFacesOutwardOnTheCircleAlone) {
  Analytic cup;
  Indices points = AddCup(cup, 0.0015);
  const Eigen::Vector2d center(0.02, -0.03);
  const auto handle = cup.AddWall(center, 0.055, 0.03, 0.08, 0.0, 0.4);
  const auto turned = cup.AddWall(center, kRadius_m + 0.0015, 0.03, 0.08, -0.5, 0.5);
  for (const auto i : turned) {
    cup.cloud.normals[i] =
        Eigen::AngleAxisd(base::Deg(50.0), Eigen::Vector3d::UnitZ()) * cup.cloud.normals[i];
  }
  const auto rounding = cup.AddWall(center, kRadius_m + 0.0015, 0.09, 0.096, -1.3, 1.3);
  for (const auto i : rounding) {
    cup.cloud.normals[i] = (cup.cloud.normals[i] + 2.0 * Eigen::Vector3d::UnitZ()).normalized();
  }
  for (const auto& more : {handle, turned, rounding}) points = samples::Joined(points, more);
  const Given given(cup.cloud);
  TopSurface top;
  top.center_C = {0.02, -0.03, 0.1};
  base::Rng rng(1);
  const auto axis = AxisFromBody(cup.cloud, points, top, given.table, given.options, rng);
  ASSERT_TRUE(axis);
  EXPECT_NEAR((axis->center_C - top.center_C).head<2>().norm(), 0.0, 1e-9);
  EXPECT_NEAR(axis->radius_m, kRadius_m, 1e-9);
}

TEST(AxisFromBody, NeedsAWallOfSixtyPointsThatIsNoWiderThanATabletopObject) {
  const auto found = [](double radius_m, std::size_t count) {
    Analytic wall;
    Indices points = wall.AddWall({0.0, 0.0}, radius_m, 0.05, 0.06, -0.6, 0.6);
    EXPECT_GE(points.size(), count);
    points.resize(count);
    const Given given(wall.cloud);
    TopSurface top;
    top.center_C = {0.0, 0.0, 0.1};
    base::Rng rng(1);
    return AxisFromBody(wall.cloud, points, top, given.table, given.options, rng).has_value();
  };
  EXPECT_FALSE(found(0.05, 59));
  EXPECT_TRUE(found(0.05, 60));
  EXPECT_TRUE(found(0.14, 300));
  EXPECT_FALSE(found(0.16, 300));
}

TEST(AxisFromBody, RefusesFlatWalls) {
  Analytic box;
  const Indices points =
      samples::Joined(box.AddRectangle({0.0, 0.0, 0.1}, {0.03, 0.0, 0.0}, {0.0, 0.03, 0.0}),
                      box.AddRectangle({0.03, 0.0, 0.05}, {0.0, 0.03, 0.0}, {0.0, 0.0, 0.04}));
  const Given given(box.cloud);
  const Part part = given.Describe(points);
  base::Rng rng(1);
  EXPECT_FALSE(AxisFromBody(box.cloud, part.points, *part.top, given.table, given.options, rng));
}

TEST(IsThinRing, EveryConditionCounts) {
  const auto thin = [](double wall_m, double radius_m, const FeatureOptions& options) {
    Analytic ring;
    TopSurface top;
    top.plane = {Eigen::Vector3d::UnitZ(), -0.1};
    top.center_C = {0.0, 0.0, 0.1};
    top.points = ring.AddDisc(top.center_C, kRadius_m, kRadius_m - wall_m);
    const RotationAxis axis{top.center_C, Eigen::Vector3d::UnitZ(), radius_m, 0.0, 0.0};
    return IsThinRing(ring.cloud, top, axis, options);
  };
  EXPECT_TRUE(thin(0.004, kRadius_m, {}));
  EXPECT_FALSE(thin(0.004, 0.03, {}));  // outside of the circle
  FeatureOptions any_area;
  any_area.axis.ring_share = 10.0;
  EXPECT_FALSE(thin(0.016, kRadius_m, any_area));  // wider than a wall
  FeatureOptions any_wall;
  any_wall.axis.max_wall_m = 1.0;
  EXPECT_FALSE(thin(0.016, kRadius_m, any_wall));  // fills 64 % of the circle
}

TEST(IsThinRing, IsALipAndNotALid) {
  const RotationAxis axis{{0.02, -0.03, 0.1}, Eigen::Vector3d::UnitZ(), kRadius_m, 0.0, 0.0};
  // A wall of w fills 1 - (1 - w / r)^2 of the circle: 0.1 of 4 mm, all of a lid's; no more than
  // 10 mm is a wall.
  for (const auto& [wall, thin] : {std::pair(0.004, true), {0.016, false}, {0.04, false}}) {
    Analytic cup;
    AddCup(cup, wall);
    const Given given(cup.cloud);
    TopSurface top;
    top.plane = {Eigen::Vector3d::UnitZ(), -0.1};
    top.center_C = axis.center_C;
    for (std::uint32_t i = 0; i < cup.cloud.size(); ++i) {
      if (cup.cloud.points[i].z() == 0.1) top.points.push_back(i);
    }
    EXPECT_EQ(IsThinRing(given.cloud, top, axis, given.options), thin) << wall;
  }
}

}  // namespace
}  // namespace rangegrasp::perception::internal
