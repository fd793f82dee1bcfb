#include "sensing/internal/camera_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sensing/line_scanner.h"

namespace rangegrasp::sensing::internal {
namespace {

TEST(CameraModel, DepthInvertsColumn) {
  const CameraModel camera{LineScannerOptions{}};
  for (double z = 0.4; z < 3.0; z += 0.01) {
    const auto depth = camera.Depth(camera.Column(0.0, z));
    ASSERT_TRUE(depth);
    EXPECT_NEAR(*depth, z, 1e-12);
  }
}

TEST(CameraModel, ColumnIsTheAngleBetweenAxisAndPoint) {
  const LineScannerOptions options;
  const CameraModel camera(options);
  const double axis = std::atan2(options.baseline_m, options.focus_distance_m);
  for (const double x : {-0.002, 0.0, 0.001}) {
    for (const double z : {0.6, 0.9, 1.7}) {
      const double angle = axis - std::atan2(options.baseline_m - x, z);
      EXPECT_NEAR(camera.Column(x, z),
                  std::tan(angle) * options.focal_length_m / options.pixel_pitch_m, 1e-9);
    }
  }
  EXPECT_NEAR(camera.Column(0.0, options.focus_distance_m), 0.0, 1e-9);
}

TEST(CameraModel, DepthPerPixelIsTheDerivative) {
  const CameraModel camera{LineScannerOptions{}};
  for (const double z : {0.6, 1.0, 1.8}) {
    const double u = camera.Column(0.0, z);
    const double h = 1e-4;
    EXPECT_NEAR(camera.DepthPerPixel(z), (*camera.Depth(u + h) - *camera.Depth(u - h)) / (2 * h),
                1e-7);
  }
}

TEST(CameraModel, NoDepthWhereTheRaysDoNotMeet) {
  const LineScannerOptions options;
  const CameraModel camera(options);
  // Parallel to the fan: q = tan(alpha) = b / F.
  const double parallel_px = options.baseline_m / options.focus_distance_m *
                             options.focal_length_m / options.pixel_pitch_m;
  EXPECT_TRUE(camera.Depth(parallel_px - 1.0));
  EXPECT_FALSE(camera.Depth(parallel_px));
  EXPECT_FALSE(camera.Depth(parallel_px + 1.0));
}

TEST(CameraModel, TheWindowEndsBeforeTheFloor) {
  const CameraModel camera{LineScannerOptions{}};
  EXPECT_FALSE(camera.InView({0.0, 0.0, 0.50}));
  EXPECT_TRUE(camera.InView({0.0, 0.0, 0.55}));
  EXPECT_TRUE(camera.InView({0.0, 0.0, 2.2}));
  EXPECT_FALSE(camera.InView({0.0, 0.0, 2.4}));
}

TEST(CameraModel, TheColumnsSpanTheFanWithTheDefaultLens) {
  const LineScannerOptions options;
  const double sensor_rad =
      2.0 * std::atan(0.5 * options.samples * options.pixel_pitch_m / options.focal_length_m);
  EXPECT_NEAR(sensor_rad, options.fan_rad, base::Deg(1.0));
}

TEST(PanAngle, IsSymmetricAndEvenlySpaced) {
  LineScannerOptions options;
  options.profiles = 11;
  EXPECT_DOUBLE_EQ(PanAngle(options, 0), -0.5 * options.pan_range_rad);
  EXPECT_DOUBLE_EQ(PanAngle(options, 5), 0.0);
  EXPECT_DOUBLE_EQ(PanAngle(options, 10), 0.5 * options.pan_range_rad);
  options.profiles = 1;
  EXPECT_EQ(PanAngle(options, 0), 0.0);
}

TEST(DepthSigma, GrowsWithTheSquareOfTheAxialDistance) {
  const LineScannerOptions options;
  const CameraModel camera(options);
  const double ratio = camera.AxialDistance(0.0, 1.4) / camera.AxialDistance(0.0, 0.7);
  EXPECT_NEAR(DepthSigma(options, 1.4) / DepthSigma(options, 0.7), ratio * ratio, 1e-12);
}

TEST(DepthSigma, OfSpeckleAloneIsItsOptionAtOneMetre) {
  LineScannerOptions options;
  options.centroid_sigma_px = options.quantisation_px = 0.0;
  EXPECT_NEAR(DepthSigma(options, 1.0), options.speckle_sigma_m, 1e-15);
}

// An error that is uniform over one step q has the standard deviation q / sqrt(12).
TEST(DepthSigma, OfQuantisationAloneIsThatOfAUniformError) {
  LineScannerOptions options;
  options.centroid_sigma_px = options.speckle_sigma_m = 0.0;
  options.quantisation_px = 0.5;
  const CameraModel camera(options);
  const double u = camera.Column(0.0, 1.0);
  const double h = 1e-3;
  const double depth_per_px = (*camera.Depth(u + h) - *camera.Depth(u - h)) / (2.0 * h);
  EXPECT_NEAR(DepthSigma(options, 1.0) / (std::abs(depth_per_px) * 0.5 / std::sqrt(12.0)), 1.0,
              1e-6);
}

}  // namespace
}  // namespace rangegrasp::sensing::internal
