#include "sensing/depth_camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/statistics.h"
#include "sensing/shapes.h"

namespace rangegrasp::sensing {
namespace {

using Eigen::Vector3d;
using CameraMeshes = std::vector<sim::VisualMesh>;

// The camera is at the origin and looks along W's z axis.
const base::Pose kCamera = base::Pose::Identity();

DepthCameraOptions Exact() {
  DepthCameraOptions options;
  options.width = 160;
  options.height = 120;
  options.disparity_sigma_px = options.disparity_step_px = 0.0;
  options.range_sigma_m = options.range_offset_m = 0.0;
  options.edge_loss = options.flying_share = options.lateral_sigma_px = 0.0;
  options.calibration_sigma_m = options.calibration_sigma_rad = 0.0;
  options.saturation_angle_rad = 0.0;
  return options;
}

DepthCameraOptions ExactFlight() {
  DepthCameraOptions options = Exact();
  options.principle = DepthPrinciple::kTimeOfFlight;
  return options;
}

/// A wall at this depth that fills the image.
sim::VisualMesh WallAt(double z_m, std::uint32_t label = 0) {
  return test::Level(z_m, -9.0, 9.0, -9.0, 9.0, label);
}

Scan LookAt(const CameraMeshes& meshes, const DepthCameraOptions& options, std::uint64_t seed = 1) {
  base::Rng rng(seed);
  return ScanScene(meshes, kCamera, options, rng);
}

std::vector<double> Depths(const Scan& scan) {
  std::vector<double> depths_m;
  for (const Vector3d& p : scan.view.image.points_C) {
    if (p.allFinite()) depths_m.push_back(p.z());
  }
  return depths_m;
}

double SigmaOf(const std::vector<double>& values) {
  double mean = 0.0, square = 0.0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  for (const double value : values) square += (value - mean) * (value - mean);
  return std::sqrt(square / static_cast<double>(values.size() - 1));
}

TEST(DepthCamera, SpacingOfAnImageOfTwoColumnsIsThatOfBoth) {
  DepthCameraOptions options = Exact();
  options.width = 2;
  options.height = 100;
  const Scan scan = LookAt({WallAt(0.8)}, options);
  EXPECT_DOUBLE_EQ(scan.view.spacing_m, geometry::MedianSpacing(scan.view.image));
}

TEST(DepthCamera, WithoutNoiseMeasuresAWallOnThePixelsRays) {
  for (const DepthCameraOptions& options : {Exact(), ExactFlight()}) {
    const Scan scan = LookAt({WallAt(0.7, 3)}, options);
    const double f = FocalLength(options);
    int measured = 0;
    for (std::size_t i = 0; i < scan.view.image.points_C.size(); ++i) {
      if (scan.truth.state[i] != SampleState::kMeasured) continue;
      ++measured;
      const double column = static_cast<double>(i % 160), row = static_cast<double>(i / 160);
      const Vector3d ray((column - 79.5) / f, (row - 59.5) / f, 1.0);
      // Rays are cast in single precision, 1e-7 of their length.
      EXPECT_LT((scan.view.image.points_C[i] - 0.7 * ray).norm(), 1e-6);
      EXPECT_EQ(scan.truth.label[i], 3U);
    }
    // Stereo has no second image for the left f b / z = 7.4 columns.
    const int columns = options.principle == DepthPrinciple::kActiveStereo ? 160 - 7 : 160;
    EXPECT_NEAR(measured, columns * 120, 120);
  }
}

TEST(DepthCamera, StereoNoiseGrowsWithTheSquaredDepthAsPredicted) {
  DepthCameraOptions options = Exact();
  options.disparity_sigma_px = 0.08;
  options.disparity_step_px = 1.0 / 32.0;
  options.window_px = options.window_rows_px = 1;
  for (const double depth_m : {0.5, 1.0, 2.0}) {
    const Scan scan = LookAt({WallAt(depth_m)}, options);
    const double sigma_m = SigmaOf(Depths(scan));
    const double expected_m = depth_m * depth_m / (FocalLength(options) * 0.05) *
                              std::hypot(0.08, 1.0 / 32.0 / std::sqrt(12.0));
    EXPECT_NEAR(StereoSigma(options, depth_m), expected_m, 1e-12);
    // For 18,000 samples, 5 standard errors are 2.6 %. The curvature of 1 / d adds less than 1 % if
    // sigma is below a tenth of the depth.
    EXPECT_NEAR(sigma_m / expected_m, 1.0, 0.04) << depth_m;
  }
}

TEST(DepthCamera, FlightNoiseGrowsWithTheRangeAndOnDarkSurfaces) {
  DepthCameraOptions options = ExactFlight();
  options.range_sigma_m = 0.002;
  options.field_right_rad = base::Deg(2.0);  // facing the wall
  CameraMeshes meshes = {WallAt(1.0)};
  meshes[0].surface.albedo = 0.85;
  EXPECT_NEAR(SigmaOf(Depths(LookAt(meshes, options))), 0.002, 0.0001);
  meshes[0].surface.albedo = 0.85 / 4.0;
  EXPECT_NEAR(SigmaOf(Depths(LookAt(meshes, options))), 0.004, 0.0002);
  CameraMeshes far = {WallAt(2.0)};
  far[0].surface.albedo = 0.85;
  EXPECT_NEAR(SigmaOf(Depths(LookAt(far, options))), 0.004, 0.0002);
}

TEST(DepthCamera, AveragingLeavesTheNoiseThatIsTheSameInAllImages) {
  DepthCameraOptions options = Exact();
  options.disparity_sigma_px = 0.1;
  const double once_m = StereoSigma(options, 1.0);
  options.fixed_share = 0.0;
  options.frames = 4;
  EXPECT_NEAR(StereoSigma(options, 1.0), once_m / 2.0, 1e-12);
  options.fixed_share = 1.0;
  EXPECT_NEAR(StereoSigma(options, 1.0), once_m, 1e-12);
}

TEST(DepthCamera, AMatchingWindowCorrelatesNeighbors) {
  constexpr int kWidth = 400, kHeight = 400, kWindow = 7, kRows = 3;
  const std::vector<float> noise = WindowNoise(kWidth, kHeight, kWindow, kRows, 5);
  const auto covariance = [&](int right, int down) {
    double sum = 0.0;
    for (int y = 0; y + down < kHeight; ++y) {
      for (int x = 0; x + right < kWidth; ++x) {
        sum += noise[static_cast<std::size_t>(y * kWidth + x)] *
               noise[static_cast<std::size_t>((y + down) * kWidth + x + right)];
      }
    }
    return sum / ((kWidth - right) * (kHeight - down));
  };
  // For 160,000 / 21 independent values, 5 standard errors are 0.06 to 0.08.
  EXPECT_NEAR(covariance(0, 0), 1.0, 0.08);
  for (const int k : {1, 3, 6, 8}) {
    EXPECT_NEAR(covariance(k, 0), std::max(0.0, 1.0 - k / 7.0), 0.08) << k;
  }
  EXPECT_NEAR(covariance(0, 1), 2.0 / 3.0, 0.08);
  EXPECT_NEAR(covariance(0, 3), 0.0, 0.08);
}

TEST(DepthCamera, TheSecondLensMissesAStripAsWideAsTheStepOfDisparity) {
  std::vector<float> disparity(300, 20.0F);
  std::fill(disparity.begin() + 100, disparity.begin() + 200, 45.0F);
  const std::vector<std::uint8_t> hidden = HiddenFromRight(disparity);
  for (std::size_t c = 0; c < hidden.size(); ++c) {
    const bool beyond = c < 20;                    // outside the right image
    const bool behind = c >= 100 - 25 && c < 100;  // left of the near part
    EXPECT_EQ(hidden[c] != 0, beyond || behind) << c;
  }
}

// Two neighbors may share a pixel of the right image.
TEST(DepthCamera, ASlantedSurfaceHidesNothingOfItself) {
  std::vector<float> disparity(300);
  for (std::size_t c = 0; c < disparity.size(); ++c) {
    disparity[c] = 20.0F + 0.4F * static_cast<float>(c);
  }
  const std::vector<std::uint8_t> hidden = HiddenFromRight(disparity);
  // The first 34 columns are outside the right image.
  EXPECT_EQ(std::count(hidden.begin() + 34, hidden.end(), 1), 0);
}

TEST(DepthCamera, AThinPoleHidesNoMoreThanItsWidth) {
  std::vector<float> disparity(300, 20.0F);
  std::fill(disparity.begin() + 150, disparity.begin() + 155, 45.0F);
  const std::vector<std::uint8_t> hidden = HiddenFromRight(disparity);
  EXPECT_EQ(std::count(hidden.begin() + 20, hidden.end(), 1), 5);
}

TEST(DepthCamera, FlyingPixelsLieBetweenTheTwoSurfaces) {
  DepthCameraOptions options = ExactFlight();
  options.flying_share = 1.0;
  options.edge_reach_px = 1.0;
  const CameraMeshes meshes = {WallAt(1.0), test::Level(0.6, -0.1, 0.1, -0.1, 0.1, 1)};
  std::size_t near = 0, far = 0, between = 0;
  for (const double z_m : Depths(LookAt(meshes, options))) {
    if (z_m < 0.6 + 1e-4) {
      ++near;
    } else if (z_m > 1.0 - 1e-4) {
      ++far;
    } else {
      ++between;
    }
  }
  EXPECT_EQ(near + far + between, 160U * 120U);
  // The square is 0.2 / 0.6 f = 34.8 pixels wide; both sides of its outline are mixed.
  EXPECT_NEAR(static_cast<double>(between), 2.0 * 4.0 * 34.8, 20.0);
}

TEST(DepthCamera, LosesTheShareOfSamplesAtDepthEdgesThatItSays) {
  DepthCameraOptions options = ExactFlight();
  options.edge_reach_px = 1.0;
  options.edge_loss = 0.4;
  const CameraMeshes meshes = {WallAt(1.0), test::Level(0.6, -0.1, 0.1, -0.1, 0.1, 1)};
  int lost = 0;
  constexpr int kSeeds = 20;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Scan scan = LookAt(meshes, options, seed);
    lost += static_cast<int>(std::ranges::count(scan.truth.state, SampleState::kDropout));
  }
  // For 5,600 draws, 5 standard errors are 0.033; the logistic curve is within 0.01.
  EXPECT_NEAR(lost / (kSeeds * 2.0 * 4.0 * 34.8), 0.4, 0.06);
}

TEST(DepthCamera, LosesGlossThatFacesItAndDarkAndGrazingSurfaces) {
  DepthCameraOptions options = Exact();
  options.saturation_angle_rad = base::Deg(10.0);
  options.dropout_patch_m = 0.0;
  const auto share_lost = [&](const sim::VisualMesh& mesh) {
    const Scan scan = LookAt({mesh}, options);
    const auto lost = std::ranges::count(scan.truth.state, SampleState::kDropout);
    const auto measured = std::ranges::count(scan.truth.state, SampleState::kMeasured);
    return static_cast<double>(lost) / static_cast<double>(lost + measured);
  };
  EXPECT_EQ(share_lost(WallAt(0.7)), 0.0);
  sim::VisualMesh glossy = WallAt(0.7);
  glossy.surface.gloss = 1.0;
  // Light returns within 10 deg if the wall is seen within 5 deg: a disc of tan(5 deg) f pixels.
  const double radius_px = std::tan(base::Deg(5.0)) * FocalLength(options);
  EXPECT_NEAR(share_lost(glossy), base::kPi * radius_px * radius_px / (153.0 * 120.0), 0.002);
  sim::VisualMesh black = WallAt(0.7);
  black.surface.albedo = 0.05;
  EXPECT_NEAR(share_lost(black), 0.5, 0.03);  // optics.h: half
  // 75 deg is three quarters of the way from 60 deg (no loss) to 80 deg (all lost).
  const double tilt = base::Deg(75.0);
  const Vector3d along(0.0, std::cos(tilt), std::sin(tilt));
  options.field_right_rad = base::Deg(4.0);
  const auto grazing = test::Plate(Vector3d(-9, 0, 0.7) - 0.5 * along, {18, 0, 0}, along);
  EXPECT_NEAR(share_lost(grazing), 0.75, 0.1);
}

TEST(DepthCamera, MeasuresWithinItsRangeOnly) {
  DepthCameraOptions options = Exact();
  options.min_depth_m = 0.5;
  options.max_depth_m = 1.5;
  EXPECT_TRUE(Depths(LookAt({WallAt(0.49)}, options)).empty());
  EXPECT_TRUE(Depths(LookAt({WallAt(1.51)}, options)).empty());
  EXPECT_FALSE(Depths(LookAt({WallAt(1.0)}, options)).empty());
  EXPECT_TRUE(Depths(LookAt({}, options)).empty());
}

TEST(DepthCamera, TheSameSeedGivesTheSameImageAndAnObjectElsewhereChangesNoNoiseHere) {
  DepthCameraOptions options;
  options.width = 160;
  options.height = 120;
  const CameraMeshes alone = {WallAt(1.0)};
  const CameraMeshes together = {WallAt(1.0), test::Level(0.6, -0.3, -0.2, -0.1, 0.1, 1)};
  const Scan a = LookAt(alone, options), again = LookAt(alone, options);
  const Scan b = LookAt(together, options), other = LookAt(alone, options, 2);
  int same = 0, different = 0;
  for (std::size_t i = 0; i < a.view.image.points_C.size(); ++i) {
    const Vector3d &p = a.view.image.points_C[i], &q = again.view.image.points_C[i];
    EXPECT_TRUE(p == q || (!p.allFinite() && !q.allFinite()));
    if (i % 160 < 120) continue;  // the right quarter
    EXPECT_TRUE(p == b.view.image.points_C[i]);
    (p == other.view.image.points_C[i] ? same : different) += 1;
  }
  EXPECT_GT(different, 10 * same);
}

TEST(DepthCamera, SeesColorsWhereItIsAskedTo) {
  DepthCameraOptions options = Exact();
  options.color_noise_levels = options.color_gain_sigma = options.color_shift_m = 0.0;
  EXPECT_TRUE(LookAt({WallAt(0.7)}, options).view.colors.empty());
  options.color = true;
  sim::VisualMesh red = WallAt(0.7);
  red.colors.plain.assign(red.mesh_W.triangles.size(), geometry::Rgb{200, 20, 20});
  const Scan scan = LookAt({red}, options);
  ASSERT_EQ(scan.view.colors.size(), scan.view.image.points_C.size());
  EXPECT_GT(scan.view.colors[80 * 160][0], 4 * scan.view.colors[80 * 160][1]);
}

}  // namespace
}  // namespace rangegrasp::sensing
