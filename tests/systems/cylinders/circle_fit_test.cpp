#include "cylinders/circle_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/random_points.h"

namespace rangegrasp::cylinders {
namespace {

using Eigen::Vector3d;
using geometry::samples::RandomVector;

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

/// Points of a circle of the radius about the axis through the centre, with noise on each.
geometry::Points Arc(const Vector3d& center, const Vector3d& normal, double radius_m,
                     double arc_rad, int count, double noise_m, base::Rng& rng) {
  const Vector3d u = normal.unitOrthogonal();
  const Vector3d v = normal.cross(u);
  geometry::Points points;
  for (int i = 0; i < count; ++i) {
    const double angle = arc_rad * i / count;
    const Vector3d noise = noise_m * RandomVector(rng);
    points.push_back(center + radius_m * (std::cos(angle) * u + std::sin(angle) * v) + noise);
  }
  return points;
}

TEST(CylinderCircle, ProductsAreThoseOfTheEquations) {
  base::Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const Vector3d a = RandomVector(rng);
    const Vector3d b = RandomVector(rng);
    const Vector3d c = RandomVector(rng);
    double ca = 0.0;
    double ba = 0.0;
    double cb = 0.0;
    for (int k = 0; k < 3; ++k) {
      ca += (c[k] - a[k]) * (b[k] - a[k]);
      ba += (c[k] - b[k]) * (a[k] - b[k]);
      cb += (a[k] - c[k]) * (b[k] - c[k]);
    }
    const auto p = ProductsOf(a, b, c);
    EXPECT_DOUBLE_EQ(p.d_ca, ca);
    EXPECT_DOUBLE_EQ(p.d_ba, ba);
    EXPECT_DOUBLE_EQ(p.d_cb, cb);
    EXPECT_DOUBLE_EQ(p.n_1, ba * cb);
    EXPECT_DOUBLE_EQ(p.n_2, cb * ca);
    EXPECT_DOUBLE_EQ(p.n_3, ca * ba);
    // The quotient's unit is m^2, so that its root is a length.
    const double r =
        std::sqrt((ca + ba) * (ba + cb) * (cb + ca) / (ba * cb + cb * ca + ca * ba)) / 2;
    EXPECT_NEAR(CircumradiusOf(p), r, 1e-9 * r);
  }
}

TEST(CylinderCircle, RadiusIsTheProductOfTheSidesByFourAreas) {
  base::Rng rng(2);
  for (int i = 0; i < 100; ++i) {
    const Vector3d a = RandomVector(rng);
    const Vector3d b = RandomVector(rng);
    const Vector3d c = RandomVector(rng);
    const double area = 0.5 * (b - a).cross(c - a).norm();
    const double r = (a - b).norm() * (b - c).norm() * (c - a).norm() / (4.0 * area);
    EXPECT_NEAR(CircumradiusOf(ProductsOf(a, b, c)), r, 1e-6 * r);
  }
}

TEST(CylinderCircle, CircleThroughThreePointsIsAsFarFromEach) {
  base::Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    const geometry::Points corners = {RandomVector(rng), RandomVector(rng), RandomVector(rng)};
    const auto circle = CircleThrough(corners[0], corners[1], corners[2]);
    ASSERT_TRUE(circle);
    for (const Vector3d& p : corners) {
      EXPECT_NEAR((p - circle->center).norm(), circle->radius_m, 1e-6 * circle->radius_m);
      EXPECT_NEAR((p - circle->center).dot(circle->normal), 0.0, 1e-6 * circle->radius_m);
    }
  }
}

TEST(CylinderCircle, ThereIsNoneThroughCollinearPoints) {
  EXPECT_FALSE(CircleThrough({0, 0, 1}, {0.1, 0, 1}, {0.3, 0, 1}));
  EXPECT_FALSE(CircleThrough({0, 0, 1}, {0, 0, 1}, {0.3, 0, 1}));
  EXPECT_FALSE(CircleThrough({0, 0, 1}, {0, 0, 1}, {0, 0, 1}));
}

TEST(CylinderCircle, AreaAndCircumference) {
  const Circle circle{.radius_m = 0.02};
  EXPECT_DOUBLE_EQ(AreaOf(circle), std::numbers::pi * 0.0004);
  EXPECT_DOUBLE_EQ(CircumferenceOf(circle), std::numbers::pi * 0.04);
}

TEST(CylinderCircle, DistanceFromTheSphereAndFromTheCurve) {
  const Circle circle{Vector3d::Zero(), Vector3d::UnitZ(), 0.03};
  const Vector3d pole(0, 0, 0.03);
  EXPECT_DOUBLE_EQ(DistanceTo(circle, pole, CircleDistance::kSphere), 0.0);
  EXPECT_DOUBLE_EQ(DistanceTo(circle, pole, CircleDistance::kCurve), std::hypot(0.03, 0.03));
  EXPECT_NEAR(DistanceTo(circle, {0.034, 0, 0.003}, CircleDistance::kCurve), 0.005, 1e-12);
}

TEST(CylinderCircle, SumAndShareAreThoseOfTheEquations) {
  base::Rng rng(4);
  const Circle circle{Vector3d(0.1, 0.2, 0.3), Vector3d::UnitZ(), 0.03};
  const auto rim = Arc(circle.center, circle.normal, 0.03, 3.0, 200, 0.002, rng);
  double sum = 0.0;
  int on = 0;
  for (const Vector3d& p : rim) {
    double squared = 0.0;
    for (int k = 0; k < 3; ++k) squared += (p[k] - circle.center[k]) * (p[k] - circle.center[k]);
    const double d = std::abs(0.03 - std::sqrt(squared));
    sum += d;
    if (d <= 0.002) ++on;
  }
  EXPECT_NEAR(SumOfDistances(circle, rim, CircleDistance::kSphere, kNoLimit), sum, 1e-12);
  EXPECT_GT(SumOfDistances(circle, rim, CircleDistance::kSphere, 0.5 * sum), 0.5 * sum);
  EXPECT_DOUBLE_EQ(ShareOn(circle, rim, CircleDistance::kSphere, 0.002), on / 200.0);
  EXPECT_EQ(ShareOn(circle, {}, CircleDistance::kSphere, 0.002), 0.0);
}

TEST(CylinderCircle, TheLeastSumOfAllDrawsWins) {
  base::Rng rng(5);
  const auto rim = Arc(Vector3d::Zero(), Vector3d::UnitZ(), 0.03, 3.0, 60, 0.0005, rng);
  base::Rng naive(7);
  double least = kNoLimit;
  for (int draw = 0; draw < 100; ++draw) {
    const auto a = naive.Index(rim.size());
    const auto b = naive.Index(rim.size());
    const auto c = naive.Index(rim.size());
    const auto circle = CircleThrough(rim[a], rim[b], rim[c]);
    if (!circle) continue;
    double sum = 0.0;
    for (const Vector3d& p : rim) sum += std::abs(circle->radius_m - (p - circle->center).norm());
    least = std::min(least, sum);
  }
  base::Rng same(7);
  const auto fit = FitRandomCircle(rim, {.draws = 100}, same);
  ASSERT_TRUE(fit);
  EXPECT_DOUBLE_EQ(fit->sum_m, least);
}

TEST(CylinderCircle, FindsAnArcAmongOutliers) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    base::Rng rng(seed);
    const Vector3d normal = RandomVector(rng).normalized();
    auto rim = Arc({0.5, -0.2, 0.9}, normal, 0.026, 3.5, 160, 0.0002, rng);
    for (int i = 0; i < 30; ++i) rim.push_back(Vector3d(0.5, -0.2, 0.9) + 0.03 * RandomVector(rng));
    const auto fit = FitRandomCircle(rim, {.draws = 100, .distance = CircleDistance::kCurve}, rng);
    ASSERT_TRUE(fit);
    // The best of some sixty clean triples; a typical one is off by about ten times the noise.
    EXPECT_NEAR(fit->circle.radius_m, 0.026, 0.002);
    EXPECT_GT(ShareOn(fit->circle, rim, CircleDistance::kSphere, 0.002), 0.8);
  }
}

TEST(CylinderCircle, NoCircleOfTooFewPointsOrOfALine) {
  base::Rng rng(1);
  EXPECT_FALSE(FitRandomCircle({}, {}, rng));
  const geometry::Points two = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_FALSE(FitRandomCircle(two, {}, rng));
  const geometry::Points line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {4, 0, 0}};
  EXPECT_FALSE(FitRandomCircle(line, {}, rng));
  EXPECT_THROW(FitRandomCircle(line, {.draws = 0}, rng), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::cylinders
