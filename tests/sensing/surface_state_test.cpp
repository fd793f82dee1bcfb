#include "sensing/surface_state.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "sensing/shapes.h"

namespace rangegrasp::sensing {
namespace {

// W = S: the laser in the origin looks along z at a wall at kWall; before it, at kPlate, stands a
// plate of |x| <= kSurfaceStateHalf, |y| <= 0.1.
constexpr double kWall = 1.0;
constexpr double kPlate = 0.8;
constexpr double kSurfaceStateHalf = 0.04;

std::vector<sim::VisualMesh> SurfaceStatePlateBeforeWall() {
  return {test::Level(kWall, -2, 2, -2, 2),
          test::Level(kPlate, -kSurfaceStateHalf, kSurfaceStateHalf, -0.1, 0.1, 1)};
}

bool InLaserShadow(double x) { return std::abs(x) * kPlate / kWall <= kSurfaceStateHalf; }

/// Where the segment from the wall's point x to the camera, at the pan angle of that point, crosses
/// the plate's plane.
double CameraCrossing(double x, double baseline_m) {
  const double pan_rad = std::atan2(x, kWall);
  const double camera_x = baseline_m * std::cos(pan_rad);
  const double camera_z = -baseline_m * std::sin(pan_rad);
  return x + (camera_x - x) * (kWall - kPlate) / (kWall - camera_z);
}

TEST(ClassifySurface, BothShadowsOfAPlateLieWhereGeometryPutsThem) {
  const LineScannerOptions options;
  std::vector<Eigen::Vector3d> points;
  const double step = 1e-4;
  for (double x = -0.2; x <= 0.2; x += step) points.emplace_back(x, 0.0, kWall);
  const auto states =
      ClassifySurface(points, SurfaceStatePlateBeforeWall(), base::Pose::Identity(), options);
  std::array<int, 5> count{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double x = points[i].x();
    ++count.at(static_cast<std::size_t>(states[i]));
    const double crossing = CameraCrossing(x, options.baseline_m);
    // Single precision at a distance of 1 m: a margin of 10 um.
    if (std::abs(std::abs(crossing) - kSurfaceStateHalf) < 1e-5) continue;
    if (std::abs(std::abs(x) * kPlate / kWall - kSurfaceStateHalf) < 1e-5) continue;
    const bool hidden = std::abs(crossing) <= kSurfaceStateHalf;
    const SurfaceState expected =
        InLaserShadow(x) ? (hidden ? SurfaceState::kBothShadows : SurfaceState::kLaserShadow)
                         : (hidden ? SurfaceState::kCameraShadow : SurfaceState::kSeen);
    EXPECT_EQ(states[i], expected) << "x = " << x;
  }
  // The laser's shadow is 2 * 0.04 / 0.8 = 100 mm long, the camera's is shifted by about
  // b (1 - 0.8) / 0.8 = 75 mm towards -x: 25 mm are in both.
  const auto length = [&](SurfaceState s) { return step * count.at(static_cast<std::size_t>(s)); };
  EXPECT_NEAR(length(SurfaceState::kLaserShadow) + length(SurfaceState::kBothShadows), 0.100,
              2 * step);
  EXPECT_NEAR(length(SurfaceState::kBothShadows), 0.025, 0.002);
  EXPECT_NEAR(length(SurfaceState::kCameraShadow), 0.075, 0.004);
}

TEST(ClassifySurface, TheHeadsOwnHousingHidesNothing) {
  const LineScannerOptions options;
  ASSERT_LT(0.06, options.near_m);
  const std::vector<sim::VisualMesh> housing = {
      test::Box({0, 0, 0.05}, {0.02, 0.02, 0.01}),
      test::Box({options.baseline_m, 0, 0.05}, {0.02, 0.02, 0.01})};
  const auto states = ClassifySurface(std::vector<Eigen::Vector3d>{{0, 0, 1}}, housing,
                                      base::Pose::Identity(), options);
  EXPECT_EQ(states[0], SurfaceState::kSeen);
}

TEST(ClassifySurface, WhatIsOutsideSweepFanOrWindowIsOutOfView) {
  const LineScannerOptions options;
  const std::vector<Eigen::Vector3d> points = {{0, 0, 1},
                                               {std::tan(base::Deg(18.0)), 0, 1},
                                               {0, std::tan(base::Deg(22.0)), 1},
                                               // the laser's fan ends before the camera's view
                                               {0, 1.02 * std::tan(0.5 * options.fan_rad), 1},
                                               {0, 0, -1},
                                               {0, 0, 0.4},
                                               {0, 0, 3.0}};
  const auto states = ClassifySurface(points, {}, base::Pose::Identity(), options);
  EXPECT_EQ(states[0], SurfaceState::kSeen);
  for (std::size_t i = 1; i < points.size(); ++i) EXPECT_EQ(states[i], SurfaceState::kOutOfView);
}

}  // namespace
}  // namespace rangegrasp::sensing
