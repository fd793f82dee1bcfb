#include "grasp/rim.h"

#include <gtest/gtest.h>

#include "grasp/fixtures.h"

namespace rangegrasp::grasp {
namespace {

using namespace test;

template <typename Height>
geometry::Points Patch(double half_m, Height height) {
  geometry::Points points;
  for (int i = -6; i <= 6; ++i) {
    for (int j = -6; j <= 6; ++j) {
      const double x = half_m * i / 6;
      const double y = half_m * j / 6;
      points.emplace_back(x, y, height(x, y));
    }
  }
  return points;
}

TEST(GaussianCurvature, OfASphereIsOneOverItsRadiusSquared) {
  for (const double R : {0.03, 0.1}) {
    const auto points =
        Patch(0.1 * R, [R](double x, double y) { return std::sqrt(R * R - x * x - y * y); });
    const auto K = GaussianCurvature(points, Vector3d(0, 0, R));
    ASSERT_TRUE(K);
    // The quadric leaves out the sphere's fourth-order terms: (0.1)^2 of the curvature.
    EXPECT_NEAR(*K * R * R, 1.0, 0.03);
  }
}

TEST(GaussianCurvature, OfACylinderIsZeroAndOfASaddleNegative) {
  const double R = 0.04;
  const auto cylinder = Patch(0.006, [R](double x, double) { return std::sqrt(R * R - x * x); });
  EXPECT_NEAR(GaussianCurvature(cylinder, Vector3d(0, 0, R)).value() * R * R, 0.0, 1e-6);
  const auto saddle = Patch(0.004, [](double x, double y) { return 10.0 * x * x - 7.0 * y * y; });
  // K = (2 * 10) (2 * -7) at the centre.
  EXPECT_NEAR(GaussianCurvature(saddle, Vector3d::Zero()).value(), -280.0, 0.05);
}

TEST(GaussianCurvature, CountsTheMixedTerm) {
  // Three times longer along x, so that the principal axes are x and y and h = 8 x y is mixed:
  // K = -8^2.
  geometry::Points points;
  for (int i = -9; i <= 9; ++i) {
    for (int j = -3; j <= 3; ++j) {
      points.emplace_back(0.001 * i, 0.001 * j, 8.0 * 0.001 * i * 0.001 * j);
    }
  }
  EXPECT_NEAR(GaussianCurvature(points, Vector3d::Zero()).value(), -64.0, 0.5);
}

TEST(GaussianCurvature, NeedsAPatch) {
  EXPECT_FALSE(GaussianCurvature(geometry::Points(5, Vector3d::Zero()), Vector3d::Zero()));
  geometry::Points line;
  for (int i = 0; i < 20; ++i) line.emplace_back(0.001 * i, 0.0, 0.0);
  EXPECT_FALSE(GaussianCurvature(line, Vector3d::Zero()));
}

TEST(SmoothAround, KeepsAConstantAndWrapsRound) {
  std::vector<double> angles, ones, pulse;
  for (int k = 0; k < 24; ++k) {
    angles.push_back(2.0 * base::kPi * k / 24);
    ones.push_back(3.0);
    pulse.push_back(k == 0 ? 1.0 : 0.0);
  }
  for (const double v : SmoothAround(angles, ones, 0.2)) EXPECT_NEAR(v, 3.0, 1e-12);
  const auto smooth = SmoothAround(angles, pulse, 0.2);
  EXPECT_NEAR(smooth[1], smooth[23], 1e-12);
  EXPECT_GT(smooth[0], smooth[1]);
  EXPECT_GT(smooth[1], smooth[2]);
}

TEST(DescribeRim, MeasuresTheWallOfACup) {
  SceneBuilder builder;
  const auto& cup = builder.AddCup(0.041, 0.004, 0.095, At(0.03, -0.02));
  const auto rim = DescribeRim(builder.scene, cup, Vector3d::UnitZ(), Vector3d::UnitX(), 24);
  ASSERT_EQ(rim.size(), 24u);
  for (const RimSector& sector : rim) {
    // 72 sides: chords lie R (1 - cos 2.5 deg) = 0.04 mm inside the circle.
    EXPECT_NEAR(sector.wall_m, 0.004, 1e-4);
    EXPECT_NEAR(sector.radius_m, 0.039, 1e-4);
  }
}

TEST(DescribeRim, FindsTheStrongestCurvature) {
  SceneBuilder builder;
  auto& cup = builder.AddCup(0.041, 0.004, 0.095, At(0.0, 0.0));
  // A bead on the rim at 90 deg.
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j <= 10; ++j) {
      const double a = 2.0 * base::kPi * i / 40;
      const double b = 0.5 * base::kPi * j / 10;
      cup.points.push_back(static_cast<std::uint32_t>(builder.scene.cloud.points.size()));
      builder.scene.cloud.points.push_back(
          Vector3d(0.0, 0.045, 0.095) +
          0.004 * Vector3d(std::cos(a) * std::sin(b), std::sin(a) * std::sin(b), std::cos(b)));
      if (j == 0 && i == 0) cup.top->rim.push_back(cup.points.back());
    }
  }
  const auto rim = DescribeRim(builder.scene, cup, Vector3d::UnitZ(), Vector3d::UnitX(), 24);
  EXPECT_DOUBLE_EQ(rim[6].curvature, 1.0);
  EXPECT_LT(rim[12].curvature, 0.1);
}

}  // namespace
}  // namespace rangegrasp::grasp
