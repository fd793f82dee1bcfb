#include "cylinders/fit_refined.h"

#include <gtest/gtest.h>

#include "cylinders/seen_cylinder.h"

namespace rangegrasp::cylinders {
namespace {

using testing_support::SeenCylinder;

const Eigen::Vector3d kFitRefinedAxis = Eigen::Vector3d::UnitX();

// Off by more than random circles are.
Barrel Start(const SeenCylinder& truth) {
  return {{Eigen::Vector3d(0.0, 0.001, -0.001), Eigen::Vector3d(1.0, 0.01, -0.02).normalized()},
          1.05 * truth.radius_m};
}

TEST(Refined, IsExactForExactPointsAndLeavesTheEndOut) {
  base::Rng rng(1);
  const SeenCylinder truth;
  const auto points = truth.Points(40, 30, true, 0.0, rng);
  const auto fit = FitRefined({points, truth.eye, kFitRefinedAxis}, Start(truth));
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->barrel.radius_m, truth.radius_m, 1e-9);
  EXPECT_LT(AngleBetween(fit->barrel.axis.direction, kFitRefinedAxis), 1e-8);
  EXPECT_LT(fit->barrel.axis.Distance(Eigen::Vector3d::Zero()), 1e-9);
}

TEST(Refined, MovesWithItsPoints) {
  base::Rng rng(2);
  const SeenCylinder truth;
  const base::Pose X_AB = testing_support::SomePose();
  const auto points = truth.Points(40, 30, true, 0.0003, rng);
  geometry::Points moved;
  for (const auto& p : points) moved.push_back(X_AB * p);
  Barrel start = Start(truth);
  const auto fit = FitRefined({points, truth.eye, kFitRefinedAxis}, start);
  start.axis = {X_AB * start.axis.point, X_AB.linear() * start.axis.direction};
  const auto there = FitRefined({moved, X_AB * truth.eye, X_AB.linear() * kFitRefinedAxis}, start);
  ASSERT_TRUE(fit && there);
  // Both rest within 1e-9 m.
  EXPECT_NEAR(fit->barrel.radius_m, there->barrel.radius_m, 1e-8);
  EXPECT_LT(AngleBetween(there->barrel.axis.direction, X_AB.linear() * fit->barrel.axis.direction),
            1e-7);
}

TEST(Refined, ManyRangeImagesWithoutWeightsScatterMore) {
  const SeenCylinder truth;
  RefineOptions alike;
  alike.weigh_incidence = false;
  double with = 0.0, without = 0.0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    base::Rng rng(seed);
    const auto points = truth.Points(30, 40, false, 0.0003, rng);
    const FitInput input{points, truth.eye, kFitRefinedAxis};
    const auto weighed = FitRefined(input, Start(truth));
    const auto plain = FitRefined(input, Start(truth), alike);
    ASSERT_TRUE(weighed && plain) << seed;
    with += std::pow(weighed->barrel.radius_m - truth.radius_m, 2);
    without += std::pow(plain->barrel.radius_m - truth.radius_m, 2);
  }
  // Of 40 squares each the ratio of sums scatters by 32 %; the weights make it smaller than half.
  EXPECT_LT(with, 0.7 * without);
}

TEST(Refined, PointsOffTheCylinderDoNotCount) {
  base::Rng rng(3);
  const SeenCylinder truth;
  auto points = truth.Points(40, 30, false, 0.0, rng);
  const std::size_t wall = points.size();
  for (std::size_t i = 0; i < wall; i += 10) {  // one in eleven hangs behind the outline
    points.push_back(points[i] + Eigen::Vector3d(0.0, 0.004, -0.01));
  }
  const auto fit = FitRefined({points, truth.eye, kFitRefinedAxis}, Start(truth));
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->barrel.radius_m, truth.radius_m, 1e-6);
}

TEST(Refined, RefusesTooFewPointsAndBadOptions) {
  const geometry::Points few(6, Eigen::Vector3d::UnitZ());
  EXPECT_FALSE(FitRefined({few, Eigen::Vector3d(0.0, 0.0, 2.0), kFitRefinedAxis}, Start({})));
  RefineOptions options;
  options.rounds = 0;
  EXPECT_THROW(FitRefined({few, Eigen::Vector3d::Zero(), kFitRefinedAxis}, Start({}), options),
               std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::cylinders
