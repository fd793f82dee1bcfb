#include "perception/internal/lying_axis.h"

#include <gtest/gtest.h>

#include "perception/analytic.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;
using geometry::Indices;
using samples::Analytic;
using samples::Given;

constexpr double kLyingAxisRadius_m = 0.035;
constexpr double kLength_m = 0.115;

/// A cylinder on the table along `yaw`, seen from `from` to `to` about its axis (0 is up), with the
/// end that faces +x.
Analytic LyingCylinder(double yaw, double from_rad, double to_rad,
                       double height_m = kLyingAxisRadius_m) {
  Analytic shape;
  const Vector3d along(std::cos(yaw), std::sin(yaw), 0.0);
  const Vector3d across(-std::sin(yaw), std::cos(yaw), 0.0);
  const Vector3d center(0.02, -0.03, height_m);
  const int around = static_cast<int>((to_rad - from_rad) * kLyingAxisRadius_m / samples::kStep_m);
  const int rows = static_cast<int>(std::lround(kLength_m / samples::kStep_m));
  for (int row = 0; row <= rows; ++row) {
    for (int k = 0; k <= around; ++k) {
      const double a = from_rad + (to_rad - from_rad) * k / around;
      const Vector3d out = std::sin(a) * across + std::cos(a) * Vector3d::UnitZ();
      shape.Add(center + (static_cast<double>(row) / rows - 0.5) * kLength_m * along +
                    kLyingAxisRadius_m * out,
                out);
    }
  }
  for (double r = kLyingAxisRadius_m - samples::kStep_m; r > 0.0; r -= samples::kStep_m) {
    const int ring = static_cast<int>(2.0 * base::kPi * r / samples::kStep_m);
    for (int k = 0; k < ring; ++k) {
      const double a = 2.0 * base::kPi * k / ring;
      shape.Add(center + 0.5 * kLength_m * along +
                    r * (std::cos(a) * across + std::sin(a) * Vector3d::UnitZ()),
                along);
    }
  }
  return shape;
}

std::optional<RotationAxis> AxisOf(const Given& given, std::uint64_t seed) {
  Indices all(given.cloud.size());
  std::iota(all.begin(), all.end(), 0U);
  base::Rng rng(seed);
  return FindLyingAxis(given.cloud, all, given.table, given.options, rng);
}

TEST(FindLyingAxis, IsThatOfTheCylinderWhateverItsYaw) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const double yaw = 0.3 * static_cast<double>(seed);
    const auto axis = AxisOf(Given(LyingCylinder(yaw, -0.6, 1.7).cloud), seed);
    ASSERT_TRUE(axis) << seed;
    const Vector3d along(std::cos(yaw), std::sin(yaw), 0.0);
    EXPECT_NEAR(std::abs(axis->direction_C.dot(along)), 1.0, 1e-9);
    EXPECT_NEAR(axis->radius_m, kLyingAxisRadius_m, 1e-9);
    // Ends are where the fifth outermost point is: the same row.
    EXPECT_NEAR(axis->length_m, kLength_m, 1e-9);
    const Vector3d middle = axis->center_C - 0.5 * axis->length_m * axis->direction_C;
    EXPECT_NEAR((middle - Vector3d(0.02, -0.03, kLyingAxisRadius_m)).norm(), 0.0, 1e-9);
  }
}

// The table says how wide a body is that lies on it; in the air its arc has to.
TEST(FindLyingAxis, IsFoundOnSomethingElseThanTheTable) {
  const auto axis = AxisOf(Given(LyingCylinder(0.4, -0.6, 1.7, 0.1).cloud), 1);
  ASSERT_TRUE(axis);
  EXPECT_NEAR(axis->radius_m, kLyingAxisRadius_m, 1e-6);
}

TEST(FindLyingAxis, NeedsAnArc) {
  EXPECT_FALSE(AxisOf(Given(LyingCylinder(0.4, -0.3, 0.8).cloud), 1));  // 63 deg
}

TEST(FindLyingAxis, IsNoneOfABoxOrOfHalfACylinder) {
  for (const double yaw : {0.0, 0.5, 1.1}) {
    const Eigen::AngleAxisd turn(yaw, Vector3d::UnitZ());
    Analytic box;
    box.AddRectangle(turn * Vector3d(0, 0, 0.05), turn * Vector3d(0.06, 0, 0),
                     turn * Vector3d(0, 0.025, 0));
    box.AddRectangle(turn * Vector3d(0, 0.025, 0.027), turn * Vector3d(-0.06, 0, 0),
                     Vector3d(0, 0, 0.023));
    EXPECT_FALSE(AxisOf(Given(box.cloud), 1)) << yaw;
  }
  // On its flat side: the circle would be under the table.
  EXPECT_FALSE(AxisOf(Given(LyingCylinder(0.4, -1.2, 1.5, 0.0).cloud), 1));
}

TEST(FindLyingAxis, IsAPartsWhereNothingStandsAndCanBeSwitchedOff) {
  Given given(LyingCylinder(0.4, -0.6, 1.7).cloud);
  Indices all(given.cloud.size());
  std::iota(all.begin(), all.end(), 0U);
  const auto part = given.Describe(all);
  ASSERT_TRUE(part.axis);
  EXPECT_TRUE(part.axis->Lies());
  given.options.lying_axes = false;
  EXPECT_FALSE(given.Describe(all).axis);
}

}  // namespace
}  // namespace rangegrasp::perception::internal
