#include "perception/internal/sensor_view.h"

#include <gtest/gtest.h>

#include <cmath>

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

TEST(SensorView, DirectionsAtOneEdgeSayNothingOfTheOther) {
  // Points at all heights, near to the right edge of the field; one in the middle aims the view.
  geometry::Points points;
  const auto add = [&](double right, double down) {
    points.emplace_back(std::tan(right), std::tan(down), 1.0);
  };
  for (int i = -200; i <= 200; ++i) add(0.899, 0.004 * i);
  for (int i = 0; i < 40'000; ++i) add(0.0, 0.0);
  const SensorView view(points, Vector3d::Zero());
  int right = 0;
  int left = 0;
  for (int i = -100; i <= 100; ++i) {
    for (double angle = 0.85; angle < 0.95; angle += 0.0005) {
      const Vector3d p(0.3 * std::tan(angle), 0.3 * std::tan(0.004 * i), 0.3);
      right += view.IsFree(p, 0.005) ? 1 : 0;
      left += view.IsFree({-p.x(), p.y(), p.z()}, 0.005) ? 1 : 0;
    }
  }
  EXPECT_GT(right, 0);
  EXPECT_EQ(left, 0);
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
