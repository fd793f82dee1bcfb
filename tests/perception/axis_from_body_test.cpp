#include "perception/internal/axis_from_body.h"

#include <gtest/gtest.h>

#include "perception/analytic.h"

namespace rangegrasp::perception::internal {
namespace {

using geometry::Indices;
using testing::Analytic;
using testing::Given;

constexpr double kRadius_m = 0.04;

/// A cup about (0.02, -0.03): its lip, the near side of its wall from outside, the far from inside.
Indices AddCup(Analytic& shape, double wall_m) {
  const Eigen::Vector2d center(0.02, -0.03);
  const auto lip = shape.AddDisc({0.02, -0.03, 0.1}, kRadius_m, kRadius_m - wall_m);
  const auto outside =
      shape.AddWall(center, kRadius_m, 0.01, 0.096, core::Deg(-75.0), core::Deg(75.0));
  const auto inside = shape.AddWall(center, kRadius_m - wall_m, 0.05, 0.096, core::Deg(105.0),
                                    core::Deg(255.0), true);
  return testing::Joined(testing::Joined(lip, outside), inside);
}

TEST(AxisFromBody, IsExactForAnExactWallWhateverTheDraws) {
  Analytic cup;
  const Indices points = AddCup(cup, 0.004);
  const Given given(cup.cloud);
  const Part part = given.Describe(points);
  ASSERT_TRUE(part.top);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    core::Rng rng(seed);
    const auto axis =
        AxisFromBody(cup.cloud, part.points, *part.top, given.table, given.options, rng);
    ASSERT_TRUE(axis);
    EXPECT_NEAR((axis->center_C - Eigen::Vector3d(0.02, -0.03, 0.1)).norm(), 0.0, 1e-9);
    EXPECT_NEAR(axis->radius_m, kRadius_m, 1e-9);
    EXPECT_EQ(axis->direction_C, Eigen::Vector3d::UnitZ());
  }
}

TEST(AxisFromBody, RefusesFlatWalls) {
  Analytic box;
  const Indices points =
      testing::Joined(box.AddRectangle({0.0, 0.0, 0.1}, {0.03, 0.0, 0.0}, {0.0, 0.03, 0.0}),
                      box.AddRectangle({0.03, 0.0, 0.05}, {0.0, 0.03, 0.0}, {0.0, 0.0, 0.04}));
  const Given given(box.cloud);
  const Part part = given.Describe(points);
  core::Rng rng(1);
  EXPECT_FALSE(AxisFromBody(box.cloud, part.points, *part.top, given.table, given.options, rng));
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
