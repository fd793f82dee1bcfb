#include "perception/internal/sensor_view.h"

#include <gtest/gtest.h>

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;

TEST(SensorView, SeesThroughAirAndNotThroughSurfaces) {
  geometry::Points wall;
  for (int i = -50; i <= 50; ++i) {
    for (int j = -50; j <= 50; ++j) wall.emplace_back(0.002 * i, 0.002 * j, 1.0);
  }
  const SensorView view(wall, Vector3d::Zero());
  EXPECT_TRUE(view.IsFree({0.01, 0.02, 0.5}, 0.005));
  EXPECT_FALSE(view.IsFree({0.01, 0.02, 0.998}, 0.005));
  EXPECT_FALSE(view.IsFree({0.01, 0.02, 1.5}, 0.005));
  EXPECT_FALSE(view.IsFree({0.3, 0.02, 0.5}, 0.005));
  EXPECT_FALSE(view.IsFree({0.0, 0.0, -0.5}, 0.005));
}

TEST(SensorViews, SpaceIsFreeIfAnyPlaceSawThroughIt) {
  // One wall at z = 1 m, seen from the origin, and one at x = 1 m.
  geometry::Points front, side;
  for (int i = -50; i <= 50; ++i) {
    for (int j = -50; j <= 50; ++j) {
      front.emplace_back(0.002 * i, 0.002 * j, 1.0);
      side.emplace_back(1.0, 0.002 * i, 0.002 * j);
    }
  }
  const SensorViews views{{SensorView(front, Vector3d::Zero()), SensorView(side, Vector3d::Zero())},
                          {1, 0}};
  EXPECT_TRUE(views.IsFree({0.0, 0.0, 0.5}, 0.005));
  EXPECT_TRUE(views.IsFree({0.5, 0.0, 0.0}, 0.005));
  EXPECT_FALSE(views.IsFree({0.5, 0.0, 0.5}, 0.005));
  EXPECT_FALSE(views.IsFree({0.0, 0.0, 1.5}, 0.005));
}

}  // namespace
}  // namespace rangegrasp::perception::internal
