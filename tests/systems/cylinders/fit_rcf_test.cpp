#include "cylinders/fit_rcf.h"

#include <gtest/gtest.h>

#include "cylinders/seen_cylinder.h"

namespace rangegrasp::cylinders {
namespace {

using testing_support::SeenCylinder;

const Eigen::Vector3d kAxis = Eigen::Vector3d::UnitX();

TEST(Gate, AsPrintedComparesSigns) {
  const Eigen::Vector3d to_eye(0.5, 0.0, 1.0);
  RcfOptions options = RcfAsPrinted();
  // n_x = 0.1, n_y = -0.99, n_z = 0.05: the wall's outline.
  const Eigen::Vector3d outline = Eigen::Vector3d(0.1, -0.99, 0.05).normalized();
  EXPECT_TRUE(PassesGate(outline, kAxis, to_eye, options));
  options.gate = RimGate::kSizes;
  EXPECT_FALSE(PassesGate(outline, kAxis, to_eye, options));
  EXPECT_TRUE(PassesGate(kAxis, kAxis, to_eye, options));
  options.gate = RimGate::kHalfway;
  EXPECT_FALSE(PassesGate(kAxis, kAxis, to_eye, options));
  EXPECT_TRUE(PassesGate(Eigen::Vector3d(1.0, 0.0, 1.0).normalized(), kAxis, to_eye, options));
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
  // A sum of sizes rests on the many; squares count below 1e-4 of the radius.
  EXPECT_NEAR(circle->radius_m, 0.03, 1e-5);
  EXPECT_NEAR(circle->center.y(), 0.004, 1e-5);
}

TEST(Rcf, FindsACylinderThatIsSeenFromAbove) {
  base::Rng rng(1);
  const SeenCylinder truth;
  const auto points = truth.Points(80, 60, true, 0.0, rng);
  const FitInput input{points, truth.eye, kAxis};
  const RcfOptions options;
  const auto fit = FitRcf(input, PrepareRcf(input, options), options, rng);
  ASSERT_TRUE(fit);
  // The rim is known to the points' spacing, 2 mm round the end.
  EXPECT_NEAR(fit->barrel.radius_m, truth.radius_m, 0.001);
  EXPECT_LT(AngleBetween(fit->barrel.axis.direction, kAxis), base::Deg(0.5));
}

TEST(Rcf, WithoutARimThereIsNoFit) {
  base::Rng rng(1);
  const SeenCylinder truth;
  const auto points = truth.Points(80, 60, false, 0.0, rng);
  const FitInput input{points, truth.eye, kAxis};
  const RcfOptions options;
  EXPECT_FALSE(FitRcf(input, PrepareRcf(input, options), options, rng));
}

TEST(Rcf, RefusesBadOptions) {
  RcfOptions options;
  options.neighborhood_m = 0.0;
  EXPECT_THROW(PrepareRcf({}, options), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::cylinders
