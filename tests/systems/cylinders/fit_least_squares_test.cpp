#include "cylinders/fit_least_squares.h"

#include <gtest/gtest.h>

#include "cylinders/seen_cylinder.h"

namespace rangegrasp::cylinders {
namespace {

using testing_support::SeenCylinder;

// |(I - d d^T)(p - c)| - r, written out (eq. 2.14) for a unit d.
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
    const double a = rng.Normal();
    const double b = rng.Normal();
    const double c = rng.Normal();
    EXPECT_NEAR(BarrelResidual(x, {a, b, c}), Transcribed(x, {a, b, c}), 1e-12);
  }
}

TEST(BarrelResidual, GradientIsThatOfFiniteDifferences) {
  BarrelParameters x;
  x << 0.1, -0.2, 0.3, 0.5, 0.8, -0.4, 0.05;
  const Eigen::Vector3d p(0.4, 0.1, -0.2);
  BarrelParameters gradient;
  BarrelResidual(x, p, &gradient);
  constexpr double kStep = 1e-6;  // central: the error is of its square
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
  const base::Pose X_AB = testing_support::SomePose();
  geometry::Points points = truth.Points(30, 20, false, 0.0, rng);
  for (auto& p : points) p = X_AB * p;
  const auto fit = FitLeastSquares(points);
  ASSERT_TRUE(fit);
  // The solver rests at a relative step of 1e-8 (the root of the rounding).
  EXPECT_NEAR(fit->barrel.radius_m, truth.radius_m, 1e-7);
  EXPECT_LT(AngleBetween(fit->barrel.axis.direction, X_AB.linear().col(0)), 1e-6);
  EXPECT_LT(fit->barrel.axis.Distance(X_AB.translation()), 1e-7);
}

TEST(LeastSquares, TheSeenEndMakesTheRadiusTooSmall) {
  base::Rng rng(1);
  const SeenCylinder truth;
  const auto fit = FitLeastSquares(truth.Points(30, 20, true, 0.0, rng));
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->barrel.radius_m, 0.99 * truth.radius_m);
}

TEST(LeastSquares, MakeNoMoreIterationsThanGranted) {
  base::Rng rng(1);
  const auto points = SeenCylinder{}.Points(30, 20, false, 0.0, rng);
  const auto one = FitLeastSquares(points, {1});
  ASSERT_TRUE(one);
  EXPECT_EQ(one->iterations, 1);
  EXPECT_GT(std::abs(one->barrel.radius_m - SeenCylinder{}.radius_m), 1e-6);
}

TEST(LeastSquares, RefuseWhatIsNoCylinder) {
  EXPECT_FALSE(FitLeastSquares(geometry::Points(6, Eigen::Vector3d::UnitX())));
  EXPECT_FALSE(FitLeastSquares(geometry::Points(20, Eigen::Vector3d::UnitX())));
  EXPECT_THROW(FitLeastSquares(geometry::Points(20), {0}), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::cylinders
