#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <vector>

#include "base/units.h"
#include "sensing/line_scanner.h"
#include "sensing/shapes.h"

// Tests the default scanner at its place in the tabletop scene.

namespace rangegrasp::sensing {
namespace {

using Eigen::Vector3d;
using Meshes = std::vector<sim::VisualMesh>;

/// At (0.80, 0, 0.62), looking to -x, pitch -37 degrees.
base::Pose ScannerPose() {
  const double pitch = base::Deg(37.0);
  Eigen::Matrix3d R_WS;
  R_WS.col(0) = Vector3d::UnitY();
  R_WS.col(2) = Vector3d(-std::cos(pitch), 0, -std::sin(pitch));
  R_WS.col(1) = R_WS.col(2).cross(R_WS.col(0));
  return base::MakePose(R_WS, {0.80, 0, 0.62});
}

Meshes Table() {
  return {test::Box({0.10, 0, -0.014}, {0.45, 0.62, 0.014}), test::Level(-0.74, -4, 4, -4, 4)};
}

Meshes TableWithObjects() {
  Meshes meshes = Table();
  for (int i = 0; i < 12; ++i) {
    const double angle = 2.0 * base::kPi * i / 12;
    const double r = 0.05 + 0.07 * (i % 2);
    const Vector3d at(r * std::cos(angle), r * std::sin(angle), 0.0);
    const auto label = static_cast<std::uint32_t>(i + 1);
    if (i % 2 == 0) {
      meshes.push_back(test::Box(at + Vector3d(0, 0, 0.05), {0.02, 0.03, 0.05}, label));
    } else {
      meshes.push_back(test::Sphere(at + Vector3d(0, 0, 0.04), 0.04, 40, label));
    }
  }
  return meshes;
}

Scan ScanOf(const Meshes& meshes, std::uint64_t seed = 1) {
  LineScannerOptions known;
  known.calibration_sigma_m = known.calibration_sigma_rad = 0.0;
  base::Rng rng(seed);
  return ScanScene(meshes, ScannerPose(), known, rng);
}

std::vector<Vector3d> Measured(const Scan& scan) {
  std::vector<Vector3d> points;
  for (std::size_t i = 0; i < scan.truth.state.size(); ++i) {
    if (scan.truth.state[i] == SampleState::kMeasured)
      points.push_back(scan.view.image.points_C[i]);
  }
  return points;
}

TEST(TabletopScan, HasAsManyPointsAsThePublishedClouds) {
  for (const Meshes& meshes : {Table(), TableWithObjects()}) {
    const std::size_t points = Measured(ScanOf(meshes)).size();
    EXPECT_GE(points, 42000u);
    EXPECT_LE(points, 76000u);
  }
}

TEST(TabletopScan, ShowsTheTableAndNotTheFloor) {
  for (const Vector3d& p : Measured(ScanOf(Table()))) EXPECT_GT(p.z(), -0.05);
}

TEST(TabletopScan, SeesADiscOfTwentyCentimetresUpToTwentyEight) {
  std::vector<Vector3d> points;
  for (const double r : {0.0, 0.1, 0.2}) {
    for (int k = 0; k < 72; ++k) {
      for (double z = 0.0; z <= 0.281; z += 0.04) {
        points.emplace_back(r * std::cos(base::Deg(5.0 * k)), r * std::sin(base::Deg(5.0 * k)), z);
      }
    }
  }
  const LineScannerOptions options;
  const auto states = ClassifySurface(points, {}, ScannerPose(), options);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(states[i], SurfaceState::kSeen) << points[i].transpose();
  }
}

TEST(TabletopScan, DepthNoiseInTheWorkspaceIsAQuarterToSixTenthsOfAMillimetre) {
  const base::Pose X_SW = ScannerPose().inverse();
  for (const double r : {0.0, 0.13}) {
    for (int k = 0; k < 36; ++k) {
      const double a = base::Deg(10.0 * k);
      for (const double z : {0.0, 0.1, 0.2}) {
        const Vector3d p_S = X_SW * Vector3d(r * std::cos(a), r * std::sin(a), z);
        const double sigma = DepthSigma({}, std::hypot(p_S.x(), p_S.z()));
        EXPECT_GT(sigma, 0.00025);
        EXPECT_LT(sigma, 0.00060);
      }
    }
  }
}

TEST(TabletopScan, NeighboursAreAboutTwoMillimetresApart) {
  const auto points = Measured(ScanOf(TableWithObjects()));
  double sum = 0.0;
  int n = 0;
  int far = 0;
  for (std::size_t i = 0; i < points.size(); i += 101) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < points.size(); ++j) {
      if (j != i) nearest = std::min(nearest, (points[i] - points[j]).squaredNorm());
    }
    sum += std::sqrt(nearest);
    if (std::sqrt(nearest) > 0.005) ++far;
    ++n;
  }
  EXPECT_NEAR(sum / n, 0.0018, 0.0003);
  EXPECT_LE(far, n / 100);
}

TEST(TabletopScan, EveryObjectIsSeen) {
  const Scan scan = ScanOf(TableWithObjects());
  std::vector<int> points(13, 0);
  for (std::size_t i = 0; i < scan.truth.state.size(); ++i) {
    if (scan.truth.state[i] == SampleState::kMeasured) ++points.at(scan.truth.label[i]);
  }
  for (std::size_t label = 1; label < points.size(); ++label) EXPECT_GT(points[label], 50);
}

TEST(TabletopScan, NoThreadOutlivesAScanAndAForkedProcessGetsTheSameBytes) {
  const auto threads = [] {
    std::size_t count = 0;
    for ([[maybe_unused]] const auto& task : std::filesystem::directory_iterator("/proc/self/task"))
      ++count;
    return count;
  };
  Meshes meshes = TableWithObjects();
  meshes.push_back(test::Sphere({0, 0, 0.2}, 0.05, 160));  // enough to tempt a parallel builder
  const std::size_t before = threads();
  const auto points = Measured(ScanOf(meshes));
  EXPECT_EQ(threads(), before);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    alarm(20);
    _exit(Measured(ScanOf(meshes)) == points ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

// W = S: the laser at the origin looks along z at a wall at kWall. In front of the wall, at kPlate,
// is a plate with |x| <= kSurfaceStateHalf and |y| <= 0.1.
constexpr double kWall = 1.0;
constexpr double kPlate = 0.8;
constexpr double kSurfaceStateHalf = 0.04;

std::vector<sim::VisualMesh> SurfaceStatePlateBeforeWall() {
  return {test::Level(kWall, -2, 2, -2, 2),
          test::Level(kPlate, -kSurfaceStateHalf, kSurfaceStateHalf, -0.1, 0.1, 1)};
}

bool InLaserShadow(double x) { return std::abs(x) * kPlate / kWall <= kSurfaceStateHalf; }

/// The x at which the segment from the wall's point x to the camera, at that point's pan angle,
/// crosses the plate's plane.
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
    // Single precision at a distance of 1 m needs a margin of 10 um.
    if (std::abs(std::abs(crossing) - kSurfaceStateHalf) < 1e-5) continue;
    if (std::abs(std::abs(x) * kPlate / kWall - kSurfaceStateHalf) < 1e-5) continue;
    const bool hidden = std::abs(crossing) <= kSurfaceStateHalf;
    const SurfaceState expected =
        InLaserShadow(x) ? (hidden ? SurfaceState::kBothShadows : SurfaceState::kLaserShadow)
                         : (hidden ? SurfaceState::kCameraShadow : SurfaceState::kSeen);
    EXPECT_EQ(states[i], expected) << "x = " << x;
  }
  // The laser's shadow is 2 * 0.04 / 0.8 = 100 mm long. The camera's shadow is shifted by about
  // b (1 - 0.8) / 0.8 = 75 mm towards -x, so 25 mm are in both.
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
