#include "perception/internal/planar.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "base/units.h"

namespace rangegrasp::perception::internal {
namespace {

TEST(HullPositions, OfASquareWithPointsInItAreItsCornersCounterClockwise) {
  const std::vector<Eigen::Vector2d> points = {{0.0, 0.0}, {0.5, 0.5}, {1.0, 1.0}, {0.0, 1.0},
                                               {1.0, 0.0}, {0.5, 0.0}, {0.3, 0.8}, {1.0, 1.0}};
  const auto hull = HullPositions(points);
  ASSERT_EQ(hull.size(), 4u);
  double area = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    area += 0.5 * Cross(points[hull[i]], points[hull[(i + 1) % 4]]);
  }
  EXPECT_NEAR(area, 1.0, 1e-12);
  EXPECT_TRUE(HullPositions({}).empty());
}

TEST(MinAreaRectangle, RecoversATurnedRectangle) {
  base::Rng rng(4);
  for (int i = 0; i < 100; ++i) {
    const double angle = rng.Uniform(0.0, base::kPi);
    const Eigen::Vector2d x(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d y(-x.y(), x.x());
    std::vector<Eigen::Vector2d> points;
    for (const double s : {-0.05, 0.05}) {
      for (const double t : {-0.02, 0.02}) points.push_back(s * x + t * y);
    }
    for (int k = 0; k < 50; ++k) {
      const double s = rng.Uniform(-0.05, 0.05);
      points.push_back(s * x + rng.Uniform(-0.02, 0.02) * y);
    }
    const Rectangle box = MinAreaRectangle(points);
    EXPECT_NEAR(box.length_m, 0.1, 1e-12);
    EXPECT_NEAR(box.width_m, 0.04, 1e-12);
    EXPECT_NEAR(std::abs(box.axis.dot(x)), 1.0, 1e-12);
  }
}

TEST(ConvexPolygon, DistanceIsZeroInsideAndEuclideanOutside) {
  const std::vector<Eigen::Vector2d> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}};
  const auto polygon = ConvexPolygon::Around(square);
  EXPECT_EQ(polygon.corners.size(), 4u);
  EXPECT_DOUBLE_EQ(polygon.Area(), 1.0);
  EXPECT_EQ(polygon.Distance({0.3, 0.9}), 0.0);
  EXPECT_DOUBLE_EQ(polygon.Distance({2.0, 0.5}), 1.0);
  EXPECT_DOUBLE_EQ(polygon.Distance({4.0, 5.0}), 5.0);
}

TEST(FilledArea, OfAnEvenlySampledRectangleIsItsAreaWithinOneRowOfCells) {
  std::vector<Eigen::Vector2d> points;
  for (int x = 0; x <= 60; ++x) {
    for (int y = 0; y <= 30; ++y) points.emplace_back(0.001 * x, 0.001 * y);
  }
  // 60 x 30 mm in cells of 6 mm about multiples of 6 mm: 11 x 6 of them.
  EXPECT_NEAR(FilledArea(points, 0.006), 66 * 0.006 * 0.006, 1e-12);
  EXPECT_EQ(FilledArea({}, 0.006), 0.0);
}

TEST(HighestLine, IsWhereAFoldIsWhateverItsDensity) {
  // A roof along x with its fold at y = 0.004; one side has three times as many points.
  geometry::Points roof;
  for (int i = 0; i < 40; ++i) {
    for (int k = 0; k <= 30; ++k) {
      const double x = 0.002 * i;
      roof.emplace_back(x, 0.004 - 0.001 * k, 0.05 - 0.0005 * k);
      if (k % 3 == 0) roof.emplace_back(x, 0.004 + 0.001 * k, 0.05 - 0.0005 * k);
    }
  }
  const geometry::Plane table{Eigen::Vector3d::UnitZ(), 0.0};
  const PlanarFrame frame =
      MakePlanarFrame(table, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX());
  EXPECT_NEAR(HighestLine(frame, table, roof), 0.004, 1e-12);
}

}  // namespace
}  // namespace rangegrasp::perception::internal
