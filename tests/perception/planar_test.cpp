#include "perception/internal/planar.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "base/rng.h"
#include "base/units.h"
#include "geometry/random_points.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::samples::RandomPoint;

TEST(HullPositions, OfASquareWithPointsInItAreItsCornersCounterClockwise) {
  const std::vector<Vector2d> points = {{0.0, 0.0}, {0.5, 0.5}, {1.0, 1.0}, {0.0, 1.0},
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
    const Vector2d x(std::cos(angle), std::sin(angle));
    const Vector2d y(-x.y(), x.x());
    std::vector<Vector2d> points;
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
  const std::vector<Vector2d> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}};
  const auto polygon = ConvexPolygon::Around(square);
  EXPECT_EQ(polygon.corners.size(), 4u);
  EXPECT_DOUBLE_EQ(polygon.Area(), 1.0);
  EXPECT_EQ(polygon.Distance({0.3, 0.9}), 0.0);
  EXPECT_DOUBLE_EQ(polygon.Distance({2.0, 0.5}), 1.0);
  EXPECT_DOUBLE_EQ(polygon.Distance({4.0, 5.0}), 5.0);
}

TEST(FilledArea, OfAnEvenlySampledRectangleIsItsAreaWithinOneRowOfCells) {
  std::vector<Vector2d> points;
  for (int x = 0; x <= 60; ++x) {
    for (int y = 0; y <= 30; ++y) points.emplace_back(0.001 * x, 0.001 * y);
  }
  // 60 x 30 mm in cells of 6 mm, centered at multiples of 6 mm: 11 x 6 cells.
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
  const geometry::Plane table{Vector3d::UnitZ(), 0.0};
  const PlanarFrame frame = MakePlanarFrame(table, Vector3d::Zero(), Vector3d::UnitX());
  EXPECT_NEAR(HighestLine(frame, table, roof), 0.004, 1e-12);
}

/// Eq. 4.18 to 4.21 as printed (with d_ac = d_ca).
Circle Transcribed(const Vector3d& A, const Vector3d& B, const Vector3d& C) {
  const double d_ca = (C - A).dot(B - A);
  const double d_ba = (C - B).dot(A - B);
  const double d_cb = (A - C).dot(B - C);
  const double n1 = d_ba * d_cb;
  const double n2 = d_cb * d_ca;
  const double n3 = d_ca * d_ba;
  const double n = n1 + n2 + n3;
  const double r = std::sqrt((d_ca + d_ba) * (d_ba + d_cb) * (d_cb + d_ca) / n) / 2.0;
  return {((n2 + n3) * A + (n3 + n1) * B + (n1 + n2) * C) / (2.0 * n), Vector3d::Zero(), r};
}

TEST(CircleThrough, IsEquidistantFromItsPointsAndAgreesWithTheTranscription) {
  base::Rng rng(1);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d a = RandomPoint(0.1, rng);
    const Vector3d b = RandomPoint(0.1, rng);
    const Vector3d c = RandomPoint(0.1, rng);
    const auto circle = CircleThrough(a, b, c);
    ASSERT_TRUE(circle);
    const double tolerance = 1e-9 * std::max(0.1, circle->radius_m * circle->radius_m / 0.01);
    for (const Vector3d& p : {a, b, c}) {
      EXPECT_NEAR((p - circle->center).norm(), circle->radius_m, tolerance);
      EXPECT_NEAR((p - circle->center).dot(circle->normal), 0.0, tolerance);
    }
    const Circle printed = Transcribed(a, b, c);
    EXPECT_NEAR(printed.radius_m, circle->radius_m, 10 * tolerance);
    EXPECT_NEAR((printed.center - circle->center).norm(), 0.0, 10 * tolerance);
  }
}

TEST(CircleThrough, RefusesCollinearAndCoincidentPoints) {
  const Vector3d a(0.1, 0.2, 0.3);
  const Vector3d d(0.01, -0.02, 0.005);
  EXPECT_FALSE(CircleThrough(a, a + d, a + 3.0 * d));
  EXPECT_FALSE(CircleThrough(a, a, a + d));
  EXPECT_FALSE(CircleThrough(a, a, a));
}

TEST(AxisDistance, IsTheLengthSquareToTheAxis) {
  base::Rng rng(2);
  for (int i = 0; i < 200; ++i) {
    const Vector3d n = RandomPoint(0.1, rng).normalized();
    const Vector3d c = RandomPoint(0.1, rng);
    const double s = rng.Uniform(-1.0, 1.0);
    const double d = rng.Uniform(0.0, 0.2);
    EXPECT_NEAR(AxisDistance(c + s * n + d * n.unitOrthogonal(), c, n), d, 1e-12);
  }
}

TEST(FitCircle, FindsANoisyRimAmongOutliers) {
  const double sigma = 0.0004;
  const double radius = 0.0375;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    base::Rng rng(seed);
    const Vector3d center = RandomPoint(0.1, rng);
    const Vector3d n = Vector3d(0.1, -0.05, 1.0).normalized();
    const Vector3d u = n.unitOrthogonal();
    const Vector3d v = n.cross(u);
    geometry::Points rim;
    for (int i = 0; i < 120; ++i) {
      const double a = 2.0 * base::kPi * i / 120;
      const double dr = sigma * rng.Normal();
      const double dn = sigma * rng.Normal();
      rim.push_back(center + (radius + dr) * (std::cos(a) * u + std::sin(a) * v) + dn * n);
    }
    for (int i = 0; i < 20; ++i) rim.push_back(center + RandomPoint(0.1, rng));
    const auto fit = FitCircle(rim, {}, rng);
    ASSERT_TRUE(fit) << seed;
    EXPECT_GE(fit->inliers.size(), 118u);  // 2 mm are 5 sigma.
    // Five standard errors of a 120-point fit (sigma * sqrt(2 / n) for centre and radius), plus the
    // effect of chance inliers at 2 mm.
    const double tolerance = 5.0 * sigma * std::sqrt(2.0 / 120) + 4.0 * 0.002 / 120;
    EXPECT_NEAR(fit->circle.radius_m, radius, tolerance) << seed;
    EXPECT_NEAR((fit->circle.center - center).norm(), 0.0, 2.0 * tolerance) << seed;
  }
}

TEST(FitCircle2, IsExactForPointsOnAnArc) {
  base::Rng rng(4);
  for (int i = 0; i < 200; ++i) {
    const double x = rng.Uniform(-0.1, 0.1);
    const Vector2d center(x, rng.Uniform(-0.1, 0.1));
    const double radius = rng.Uniform(0.01, 0.1);
    std::vector<Vector2d> points;
    for (int k = 0; k < 20; ++k) {
      const double a = rng.Uniform(0.0, 2.0);
      points.push_back(center + radius * Vector2d(std::cos(a), std::sin(a)));
    }
    const auto fit = FitCircle2(points);
    ASSERT_TRUE(fit);
    EXPECT_NEAR((fit->center - center).norm(), 0.0, 1e-9);
    EXPECT_NEAR(fit->radius_m, radius, 1e-9);
  }
  EXPECT_FALSE(FitCircle2(std::vector<Vector2d>{{0.0, 0.0}, {1.0, 0.0}}));
  EXPECT_FALSE(FitCircle2(std::vector<Vector2d>{{0.0, 0.0}, {1.0, 1.0}, {2.0, 2.0}, {5.0, 5.0}}));
}

TEST(FitCircle, RefusesACircleThatIsTooWide) {
  for (const auto& [radius, found] : {std::pair(0.149, true), {0.151, false}}) {
    geometry::Points rim;
    for (int i = 0; i < 100; ++i) {
      const double a = 2.0 * base::kPi * i / 100;
      rim.emplace_back(radius * std::cos(a), radius * std::sin(a), 0.0);
    }
    base::Rng rng(1);
    EXPECT_EQ(FitCircle(rim, {}, rng).has_value(), found) << radius;
  }
}

TEST(FitCircle, FindsNothingInALine) {
  base::Rng rng(3);
  geometry::Points line;
  for (int i = 0; i < 50; ++i) line.emplace_back(0.001 * i, 0.002 * i, 0.0);
  EXPECT_FALSE(FitCircle(line, {}, rng));
  EXPECT_FALSE(FitCircle({}, {}, rng));
}

}  // namespace
}  // namespace rangegrasp::perception::internal
