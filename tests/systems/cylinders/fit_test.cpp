#include "cylinders/fit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "base/frames.h"
#include "base/rng.h"
#include "base/units.h"
#include "geometry/random_points.h"

namespace rangegrasp::cylinders {
namespace {

/// A cylinder along x about the origin, with those of its points that an eye at +z sees.
struct SeenCylinder {
  double radius_m = 0.02;
  double height_m = 0.1;
  Eigen::Vector3d eye = Eigen::Vector3d(0.5, 0.0, 0.7);

  /// Rows along the visible side of the wall, without the outline, and rings over the upper end
  /// (+x). Noise moves each point along its ray.
  geometry::Points Points(int rows, int columns, bool end, double noise_m, base::Rng& rng) const {
    geometry::Points points;
    const double half_angle = std::acos(radius_m / eye.z()) - base::Deg(3.0);
    for (int i = 0; i < rows; ++i) {
      for (int k = 0; k < columns; ++k) {
        const double x = height_m * ((i + 0.5) / rows - 0.5);
        const double angle = half_angle * (2.0 * (k + 0.5) / columns - 1.0);
        points.emplace_back(x, radius_m * std::sin(angle), radius_m * std::cos(angle));
      }
    }
    for (int i = 0; end && i < rows / 2; ++i) {
      for (int k = 0; k < columns; ++k) {
        const double r = radius_m * std::sqrt((i + 0.5) / (rows / 2));
        const double angle = 2.0 * base::kPi * k / columns;
        points.emplace_back(0.5 * height_m, r * std::sin(angle), r * std::cos(angle));
      }
    }
    for (auto& p : points) {
      const double noise = noise_m * rng.Normal();
      p += noise * (p - eye).normalized();
    }
    return points;
  }
};

/// A pose that is not aligned with the axes.
base::Pose SomePose() {
  return base::MakePose(
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix(),
      {0.3, -0.2, 0.9});
}

const Barrel kBarrel{{Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()}, 0.02};

TEST(AngleBetween, IsThatOfAxesWhateverTheirSigns) {
  const Eigen::Vector3d turned(std::cos(0.3), std::sin(0.3), 0.0);
  EXPECT_NEAR(AngleBetween(Eigen::Vector3d::UnitX(), turned), 0.3, 1e-12);
  EXPECT_NEAR(AngleBetween(Eigen::Vector3d::UnitX(), -turned), 0.3, 1e-12);
}

TEST(Incidence, IsThatOfTheNormalWhereTheRayMeetsTheBarrel) {
  const Eigen::Vector3d eye(0.3, 0.0, 0.7);
  for (const double angle : {-1.2, -0.4, 0.0, 0.9}) {
    const Eigen::Vector3d normal(0.0, std::sin(angle), std::cos(angle));
    const Eigen::Vector3d p = kBarrel.radius_m * normal;
    const Eigen::Vector3d ray = (p - eye).normalized();
    const Eigen::Vector3d tangent = Eigen::Vector3d::UnitX().cross(normal);
    const Incidence incidence = IncidenceOf(kBarrel, eye, p);
    EXPECT_NEAR(incidence.radial, std::abs(ray.dot(normal)), 1e-12);
    EXPECT_NEAR(incidence.tangential, std::abs(ray.dot(tangent)), 1e-12);
    // A point that noise moved along the ray has the same incidence.
    EXPECT_NEAR(IncidenceOf(kBarrel, eye, p + 0.003 * ray).radial, incidence.radial, 1e-12);
  }
}

TEST(Incidence, OfARayPastTheBarrelIsThatOfItsOutline) {
  const Incidence incidence = IncidenceOf(kBarrel, {0.0, 0.0, 0.7}, {0.0, 0.05, 0.0});
  EXPECT_EQ(incidence.radial, 0.0);
  EXPECT_NEAR(incidence.tangential, 1.0, 1e-12);
}

TEST(DistanceNoise, IsThatOfDrawnPoints) {
  const Eigen::Vector3d eye(0.3, 0.0, 0.7);
  const RayNoise noise{0.0008, 0.0};
  for (const double angle : {0.0, 0.8, 1.3}) {
    const Eigen::Vector3d p =
        kBarrel.radius_m * Eigen::Vector3d(0.0, std::sin(angle), std::cos(angle));
    const Eigen::Vector3d ray = (p - eye).normalized();
    base::Rng rng(5);
    constexpr int kDraws = 100000;
    double sum = 0.0, squares = 0.0;
    for (int k = 0; k < kDraws; ++k) {
      const double distance = kBarrel.Distance(p + noise.along_m * rng.Normal() * ray);
      sum += distance;
      squares += distance * distance;
    }
    const double mean = sum / kDraws;
    const double variance = squares / kDraws - mean * mean;
    const DistanceNoise expected =
        DistanceNoiseOf(noise, IncidenceOf(kBarrel, eye, p), kBarrel.radius_m);
    // 5 standard errors of the mean, and third-order terms: s^3 / r^2.
    EXPECT_NEAR(expected.mean_m, mean,
                5.0 * std::sqrt(variance / kDraws) + std::pow(0.0008, 3) / std::pow(0.02, 2));
    // 5 standard errors of a variance are 5 sqrt(2 / n) = 2.2 %; next terms: (s / r)^2 = 0.2 %.
    EXPECT_NEAR(expected.variance_m2 / variance, 1.0, 0.03);
  }
}

// Direct implementation of |(I - d d^T)(p - c)| - r (eq. 2.14) for a unit d.
double Transcribed(const BarrelParameters& x, const Eigen::Vector3d& p) {
  const Eigen::Vector3d d = x.segment<3>(3).normalized();
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
  return (across * (p - x.head<3>())).norm() - x[6];
}

TEST(BarrelResidual, IsEquation214ForAnyLengthOfTheDirection) {
  base::Rng rng(1);
  for (int k = 0; k < 100; ++k) {
    BarrelParameters x;
    for (int i = 0; i < x.size(); ++i) x[i] = rng.Normal();
    const Eigen::Vector3d p = geometry::samples::RandomVector(rng);
    EXPECT_NEAR(BarrelResidual(x, p), Transcribed(x, p), 1e-12);
  }
}

TEST(BarrelResidual, GradientIsThatOfFiniteDifferences) {
  BarrelParameters x;
  x << 0.1, -0.2, 0.3, 0.5, 0.8, -0.4, 0.05;
  const Eigen::Vector3d p(0.4, 0.1, -0.2);
  BarrelParameters gradient;
  BarrelResidual(x, p, &gradient);
  constexpr double kStep = 1e-6;  // central differences: the error is of order kStep^2
  for (int i = 0; i < x.size(); ++i) {
    BarrelParameters high = x, low = x;
    high[i] += kStep;
    low[i] -= kStep;
    EXPECT_NEAR(gradient[i], (Transcribed(high, p) - Transcribed(low, p)) / (2.0 * kStep), 1e-8);
  }
}

TEST(LeastSquares, FindTheCylinderOfExactPointsOfItsSeenSide) {
  base::Rng rng(1);
  const SeenCylinder truth;
  const base::Pose X_AB = SomePose();
  geometry::Points points = truth.Points(30, 20, false, 0.0, rng);
  for (auto& p : points) p = X_AB * p;
  const auto fit = FitLeastSquares(points);
  ASSERT_TRUE(fit);
  // The solver stops at a relative step of 1e-8 (the root of the rounding error).
  EXPECT_NEAR(fit->radius_m, truth.radius_m, 1e-7);
  EXPECT_LT(AngleBetween(fit->axis.direction, X_AB.linear().col(0)), 1e-6);
  EXPECT_LT(fit->axis.Distance(X_AB.translation()), 1e-7);
}

TEST(LeastSquares, TheSeenEndMakesTheRadiusTooSmall) {
  base::Rng rng(1);
  const SeenCylinder truth;
  const auto fit = FitLeastSquares(truth.Points(30, 20, true, 0.0, rng));
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->radius_m, 0.99 * truth.radius_m);
}

TEST(LeastSquares, MakeNoMoreIterationsThanGranted) {
  base::Rng rng(1);
  const auto points = SeenCylinder{}.Points(30, 20, false, 0.0, rng);
  const auto one = FitLeastSquares(points, 1);
  ASSERT_TRUE(one);
  EXPECT_GT(std::abs(one->radius_m - SeenCylinder{}.radius_m), 1e-6);
}

TEST(LeastSquares, RefuseWhatIsNoCylinder) {
  EXPECT_FALSE(FitLeastSquares(geometry::Points(6, Eigen::Vector3d::UnitX())));
  EXPECT_FALSE(FitLeastSquares(geometry::Points(20, Eigen::Vector3d::UnitX())));
}

const Eigen::Vector3d kAxis = Eigen::Vector3d::UnitX();
constexpr double kNeighborhood_m = 0.005;

TEST(Gate, AsPrintedComparesSigns) {
  // A normal at the wall's outline.
  const Eigen::Vector3d outline_S = Eigen::Vector3d(0.1, -0.99, 0.05).normalized();
  EXPECT_TRUE(PassesGate(outline_S, true));
  EXPECT_TRUE(PassesGate(Eigen::Vector3d::UnitX(), true));
  EXPECT_FALSE(PassesGate(Eigen::Vector3d::UnitX(), false));
  EXPECT_TRUE(PassesGate(Eigen::Vector3d(1.0, 0.0, 1.0).normalized(), false));
}

TEST(CircleOnAxis, OfExactPointsIsExactAndStepsOverOutliers) {
  geometry::Points rim;
  for (int k = 0; k < 60; ++k) {
    const double angle = base::Deg(6.0 * k);
    rim.emplace_back(0.001 * (k % 3), 0.004 + 0.03 * std::cos(angle), 0.03 * std::sin(angle));
  }
  for (int k = 0; k < 10; ++k) rim.emplace_back(0.0, 0.004 + 0.02, 0.001 * k);
  const auto circle = CircleOnAxis(rim, kAxis, {Eigen::Vector3d::Zero(), kAxis, 0.025});
  ASSERT_TRUE(circle);
  // A sum of absolute residuals follows the majority; those below 1e-4 of the radius are squared.
  EXPECT_NEAR(circle->radius_m, 0.03, 1e-5);
  EXPECT_NEAR(circle->center.y(), 0.004, 1e-5);
}

TEST(Rcf, FindsACylinderThatIsSeenFromAbove) {
  base::Rng rng(1);
  const SeenCylinder truth;
  const auto points = truth.Points(80, 60, true, 0.0, rng);
  const FitInput input{points, truth.eye, kAxis};
  const auto fit = FitRcf(input, PrepareRcf(input, kNeighborhood_m), 100, false, rng);
  ASSERT_TRUE(fit);
  // The rim is known to within the points' spacing, 2 mm around the end.
  EXPECT_NEAR(fit->radius_m, truth.radius_m, 0.001);
  EXPECT_LT(AngleBetween(fit->axis.direction, kAxis), base::Deg(0.5));
}

// Exact normals of barrel points give points of the axis, and so its exact direction (algorithm 1).
// Points of the visible end near its rim are on the cylinder, too, but p - n r is off the axis.
TEST(Rcf, AsPrintedLeavesOutTheEnd) {
  base::Rng rng(1);
  const SeenCylinder truth;
  const auto points = truth.Points(80, 60, true, 0.0, rng);
  RcfPreparation exact;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d radial(0.0, p.y(), p.z());
    const bool is_end = p.x() == 0.5 * truth.height_m;
    exact.normals.push_back(is_end ? kAxis : radial.normalized());
    exact.curved.push_back(is_end && radial.norm() > 0.99 * truth.radius_m);  // the outer ring
  }
  const auto fit = FitRcf({points, truth.eye, kAxis}, exact, 100, true, rng);
  ASSERT_TRUE(fit);
  EXPECT_LT(AngleBetween(fit->axis.direction, kAxis), 1e-9);
}

// As printed, curvature points count for the axis as well, and normals estimated across the rim
// tilt it.
TEST(Rcf, AsPrintedTakesMoreThanTheWall) {
  base::Rng points_rng(1);
  const SeenCylinder truth;
  const auto points = truth.Points(80, 60, true, 0.0, points_rng);
  const FitInput input{points, truth.eye, kAxis};
  const auto error = [&](bool as_printed) {
    base::Rng rng(1);
    const auto fit = FitRcf(input, PrepareRcf(input, kNeighborhood_m), 100, as_printed, rng);
    return fit ? AngleBetween(fit->axis.direction, kAxis) : base::kPi;
  };
  EXPECT_GT(error(true), error(false));
}

TEST(Rcf, WithoutARimThereIsNoFit) {
  base::Rng rng(1);
  const SeenCylinder truth;
  const auto points = truth.Points(80, 60, false, 0.0, rng);
  const FitInput input{points, truth.eye, kAxis};
  EXPECT_FALSE(FitRcf(input, PrepareRcf(input, kNeighborhood_m), 100, false, rng));
}

// Off by more than random circles.
Barrel Start(const SeenCylinder& truth) {
  return {{Eigen::Vector3d(0.0, 0.001, -0.001), Eigen::Vector3d(1.0, 0.01, -0.02).normalized()},
          1.05 * truth.radius_m};
}

TEST(Refined, IsExactForExactPointsAndLeavesTheEndOut) {
  base::Rng rng(1);
  const SeenCylinder truth;
  const auto points = truth.Points(40, 30, true, 0.0, rng);
  const auto fit = FitRefined({points, truth.eye, kAxis}, Start(truth));
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->radius_m, truth.radius_m, 1e-9);
  EXPECT_LT(AngleBetween(fit->axis.direction, kAxis), 1e-8);
  EXPECT_LT(fit->axis.Distance(Eigen::Vector3d::Zero()), 1e-9);
}

TEST(Refined, MovesWithItsPoints) {
  base::Rng rng(2);
  const SeenCylinder truth;
  const base::Pose X_AB = SomePose();
  const auto points = truth.Points(40, 30, true, 0.0003, rng);
  geometry::Points moved;
  for (const auto& p : points) moved.push_back(X_AB * p);
  Barrel start = Start(truth);
  const auto fit = FitRefined({points, truth.eye, kAxis}, start);
  start.axis = {X_AB * start.axis.point, X_AB.linear() * start.axis.direction};
  const auto there = FitRefined({moved, X_AB * truth.eye, X_AB.linear() * kAxis}, start);
  ASSERT_TRUE(fit && there);
  // Both converge to within 1e-9 m.
  EXPECT_NEAR(fit->radius_m, there->radius_m, 1e-8);
  EXPECT_LT(AngleBetween(there->axis.direction, X_AB.linear() * fit->axis.direction), 1e-7);
}

TEST(Refined, RadiusScattersLessThanThatOfUnweightedLeastSquares) {
  const SeenCylinder truth;
  double with = 0.0, without = 0.0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    base::Rng rng(seed);
    const auto points = truth.Points(30, 40, false, 0.0003, rng);
    const FitInput input{points, truth.eye, kAxis};
    const auto weighed = FitRefined(input, Start(truth));
    const auto plain = FitLeastSquares(points);
    ASSERT_TRUE(weighed && plain) << seed;
    with += std::pow(weighed->radius_m - truth.radius_m, 2);
    without += std::pow(plain->radius_m - truth.radius_m, 2);
  }
  // With 40 squares each, the ratio of sums scatters by 32 %; the weights bring it below half.
  EXPECT_LT(with, 0.7 * without);
}

TEST(Refined, PointsOffTheCylinderDoNotCount) {
  base::Rng rng(3);
  const SeenCylinder truth;
  auto points = truth.Points(40, 30, false, 0.0, rng);
  const std::size_t wall = points.size();
  for (std::size_t i = 0; i < wall; i += 10) {  // one point in eleven floats behind the outline
    points.push_back(points[i] + Eigen::Vector3d(0.0, 0.004, -0.01));
  }
  const auto fit = FitRefined({points, truth.eye, kAxis}, Start(truth));
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->radius_m, truth.radius_m, 1e-6);
}

TEST(Refined, RefusesTooFewPoints) {
  const geometry::Points few(6, Eigen::Vector3d::UnitZ());
  EXPECT_FALSE(FitRefined({few, Eigen::Vector3d(0.0, 0.0, 2.0), kAxis}, Start({})));
}

}  // namespace
}  // namespace rangegrasp::cylinders
