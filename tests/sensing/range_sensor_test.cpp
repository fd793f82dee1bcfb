#include "sensing/range_sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "base/error.h"
#include "base/units.h"
#include "error_of.h"
#include "sensing/depth_camera.h"
#include "sensing/line_scanner.h"
#include "temp_folder.h"

namespace rangegrasp::sensing {
namespace {

using ::testing::HasSubstr;

class SensorFile : public ::testing::Test {
 protected:
  LineScannerOptions Read(const std::string& text) {
    return ReadLineScanner(folder_.Write("sensor.yaml", text));
  }
  /// The error's text after the file's name.
  std::string Error(const std::string& text) {
    const std::string what = testing_support::ErrorOf([&] { Read(text); });
    const std::string file = (folder_ / "sensor.yaml").string();
    EXPECT_TRUE(what.starts_with(file)) << what;
    return what.substr(std::min(file.size(), what.size()));
  }

  // A separate folder, since tests of several builds may run at once.
  const testing_support::TempFolder folder_;
};

void ExpectSame(const LineScannerOptions& a, const LineScannerOptions& b) {
  EXPECT_EQ(a.samples, b.samples);
  EXPECT_EQ(a.profiles, b.profiles);
  EXPECT_EQ(a.sensor_pixels, b.sensor_pixels);
  EXPECT_DOUBLE_EQ(a.fan_rad, b.fan_rad);
  EXPECT_DOUBLE_EQ(a.pan_range_rad, b.pan_range_rad);
  EXPECT_DOUBLE_EQ(a.baseline_m, b.baseline_m);
  EXPECT_DOUBLE_EQ(a.focal_length_m, b.focal_length_m);
  EXPECT_DOUBLE_EQ(a.pixel_pitch_m, b.pixel_pitch_m);
  EXPECT_DOUBLE_EQ(a.focus_distance_m, b.focus_distance_m);
  EXPECT_DOUBLE_EQ(a.near_m, b.near_m);
  EXPECT_DOUBLE_EQ(a.line_width_m, b.line_width_m);
  EXPECT_DOUBLE_EQ(a.blur_px, b.blur_px);
  EXPECT_DOUBLE_EQ(a.centroid_sigma_px, b.centroid_sigma_px);
  EXPECT_DOUBLE_EQ(a.speckle_sigma_m, b.speckle_sigma_m);
  EXPECT_DOUBLE_EQ(a.correlation_samples, b.correlation_samples);
  EXPECT_DOUBLE_EQ(a.quantisation_px, b.quantisation_px);
  EXPECT_DOUBLE_EQ(a.pan_jitter_rad, b.pan_jitter_rad);
  EXPECT_DOUBLE_EQ(a.dropout_begin_rad, b.dropout_begin_rad);
  EXPECT_DOUBLE_EQ(a.dropout_end_rad, b.dropout_end_rad);
  EXPECT_DOUBLE_EQ(a.saturation_angle_rad, b.saturation_angle_rad);
}

TEST_F(SensorFile, TheProjectsOwnStatesTheDefaults) {
  const std::filesystem::path root = RANGEGRASP_SOURCE_DIR;
  ExpectSame(ReadLineScanner(root / "models/sensors/line_scanner.yaml"), LineScannerOptions{});
}

TEST_F(SensorFile, WhatIsAbsentKeepsItsDefault) { ExpectSame(Read("samples: 512\n"), {}); }

TEST_F(SensorFile, ValuesAreInTheUnitOfTheirKey) {
  const auto options = Read(
      "type: line_scanner\nprofiles: 7\nfan_deg: 30\nbaseline_mm: 250\npixel_pitch_um: 12\n"
      "quantisation_px: 0.5\n");
  LineScannerOptions expected;
  expected.profiles = 7;
  expected.fan_rad = base::Deg(30.0);
  expected.baseline_m = 0.25;
  expected.pixel_pitch_m = 12e-6;
  expected.quantisation_px = 0.5;
  ExpectSame(options, expected);
}

TEST_F(SensorFile, AnUnknownKeyIsNamedWithItsLineAndTheNearestKey) {
  const std::string error = Error("samples: 512\n\nbase_line_mm: 300\n");
  EXPECT_THAT(error, HasSubstr(":3: unknown key 'base_line_mm'"));
  EXPECT_THAT(error, HasSubstr("'baseline_mm'"));
}

TEST_F(SensorFile, ThePlaceOfALineScannerIsInTheScene) {
  for (const std::string key : {"place", "position"}) {
    EXPECT_THAT(Error("samples: 512\n" + key + ": {x_mm: 100}\n"),
                AllOf(HasSubstr(":2: key '" + key + "': "), HasSubstr("site \"scanner\"")));
  }
}

TEST_F(SensorFile, AWrongTypeIsNamedWithItsLine) {
  EXPECT_THAT(Error("samples: many\n"),
              HasSubstr(":1: key 'samples': 'many' must be a whole number"));
  EXPECT_THAT(Error("samples: 1.5\n"), HasSubstr("'1.5' must be a whole number from 2 to 8192"));
  EXPECT_THAT(Error("fan_deg: 35\nblur_px: [1]\n"),
              AllOf(HasSubstr(":2: key 'blur_px': must be a number"), HasSubstr(", not a list")));
  EXPECT_THAT(Error("type: stereo\n"),
              HasSubstr(":1: key 'type': 'stereo' must be one of line_scanner"));
  EXPECT_THAT(Error("- samples\n"), HasSubstr(":1: the file must contain 'key: value' lines"));
}

TEST_F(SensorFile, AValueOutOfRangeIsNamedWithItsLineAndRange) {
  EXPECT_THAT(Error("fan_deg: 200\n"),
              HasSubstr(":1: key 'fan_deg': '200' must be a number from 0.1 to 120"));
  EXPECT_THAT(Error("samples: 9\nprofiles: 0\n"), HasSubstr(":2: key 'profiles': '0' must be"));
  EXPECT_THAT(Error("blur_px: .nan\n"), HasSubstr(":1: key 'blur_px': '.nan' must be"));
  EXPECT_THAT(Error("line_width_mm: -1\n"), HasSubstr(":1: key 'line_width_mm': '-1' must be"));
  EXPECT_THAT(Error("near_mm: 0.3\n"),  // metres
              HasSubstr(":1: key 'near_mm': '0.3' must be a number from 10 to 10000"));
}

TEST_F(SensorFile, DropOutsMustBeginBeforeTheyEnd) {
  EXPECT_THAT(Error("\ndropout_begin_deg: 85\n"), HasSubstr(":2: key 'dropout_begin_deg'"));
  EXPECT_THAT(Error("\n\ndropout_end_deg: 50\n"),
              HasSubstr(":3: key 'dropout_end_deg': dropout_begin_deg must be less"));
}

TEST_F(SensorFile, AKeyGivenTwiceIsAnError) {
  EXPECT_THAT(Error("samples: 5\nfan_deg: 30\nsamples: 6\n"),
              HasSubstr(":3: key 'samples': is given twice"));
}

TEST_F(SensorFile, ASyntaxErrorIsNamedWithItsLine) {
  EXPECT_THAT(Error("samples: 5\nfan_deg: [3\n"), HasSubstr(":3: "));
}

TEST_F(SensorFile, AMissingFileIsAnError) {
  EXPECT_THROW(ReadLineScanner(folder_ / "missing.yaml"), base::InputError);
}

TEST(LineScannerOptionsCheck, NamesTheKeyInItsUnit) {
  LineScannerOptions options;
  EXPECT_NO_THROW(CheckOptions(options));
  options.fan_rad = base::Deg(200.0);
  EXPECT_EQ(testing_support::ErrorOf<std::invalid_argument>([&] { CheckOptions(options); }),
            "line scanner: fan_deg: 200 is out of range, must be from 0.1 to 120");
}

TEST(LineScannerOptionsCheck, AScanWithOptionsOutOfRangeIsRefused) {
  base::Rng rng(1);
  LineScannerOptions options;
  options.samples = 0;
  EXPECT_THROW(ScanScene({}, base::Pose::Identity(), options, rng), std::invalid_argument);
  options = {};
  options.dropout_begin_rad = options.dropout_end_rad;
  EXPECT_THROW(ScanScene({}, base::Pose::Identity(), options, rng), std::invalid_argument);
}

class DepthCameraFile : public ::testing::Test {
 protected:
  DepthCameraOptions Read(const std::string& text) {
    return ReadDepthCamera(folder_.Write("camera.yaml", text));
  }
  std::string Error(const std::string& text) {
    return testing_support::ErrorOf([&] { Read(text); });
  }
  const testing_support::TempFolder folder_;
};

TEST_F(DepthCameraFile, TheProjectsStereoCameraStatesTheDefaults) {
  const std::filesystem::path sensors = RANGEGRASP_SOURCE_DIR "/models/sensors";
  const DepthCameraOptions file = ReadDepthCamera(sensors / "depth_camera_active_stereo.yaml");
  const DepthCameraOptions defaults;
  EXPECT_EQ(file.principle, defaults.principle);
  EXPECT_EQ(file.width, defaults.width);
  EXPECT_EQ(file.height, defaults.height);
  EXPECT_EQ(file.window_px, defaults.window_px);
  EXPECT_DOUBLE_EQ(StereoSigma(file, 0.7), StereoSigma(defaults, 0.7));
  EXPECT_DOUBLE_EQ(file.edge_loss, defaults.edge_loss);
  EXPECT_DOUBLE_EQ(file.max_depth_m, defaults.max_depth_m);
  EXPECT_TRUE(file.color);
}

TEST_F(DepthCameraFile, BothCamerasHaveTheirDataSheetsFields) {
  const std::filesystem::path sensors = RANGEGRASP_SOURCE_DIR "/models/sensors";
  const double stereo_deg =
      2.0 * FieldOf(ReadRangeSensor(sensors / "depth_camera_active_stereo.yaml")).half_down_rad;
  EXPECT_NEAR(stereo_deg, base::Deg(62.0), base::Deg(3.0));  // the data sheet's tolerance
  const auto flight = ReadRangeSensor(sensors / "depth_camera_time_of_flight.yaml");
  EXPECT_EQ(std::get<DepthCameraOptions>(flight).principle, DepthPrinciple::kTimeOfFlight);
  EXPECT_NEAR(2.0 * FieldOf(flight).half_down_rad, base::Deg(65.0), base::Deg(5.0));
}

TEST_F(DepthCameraFile, APlaceLooksWhereItSays) {
  const auto options = Read(
      "type: depth_camera\n"
      "place: {x_mm: 400, y_mm: 0, z_mm: 300, look_x_mm: 0, look_y_mm: 0, look_z_mm: 0}\n");
  ASSERT_TRUE(options.X_WS);
  EXPECT_TRUE(options.X_WS->translation().isApprox(Eigen::Vector3d(0.4, 0.0, 0.3)));
  EXPECT_TRUE(options.X_WS->linear().col(2).isApprox(Eigen::Vector3d(-0.8, 0.0, -0.6)));
  EXPECT_LT(options.X_WS->linear().col(1).z(), 0.0);  // y down
  EXPECT_NEAR(options.X_WS->linear().determinant(), 1.0, 1e-12);
  const auto above = Read(
      "type: depth_camera\n"
      "place: {x_mm: 0, y_mm: 0, z_mm: 800, look_x_mm: 0, look_y_mm: 0, look_z_mm: 0}\n");
  EXPECT_NEAR(above.X_WS->linear().determinant(), 1.0, 1e-12);
}

TEST_F(DepthCameraFile, ErrorsNameTheKey) {
  EXPECT_THAT(Error("type: depth_camera\nwidht_px: 3\n"), HasSubstr("width_px"));
  EXPECT_THAT(Error("type: depth_camera\nframes: 0\n"), HasSubstr("frames"));
  EXPECT_THAT(Error("type: depth_camera\nmin_depth_mm: 4000\n"), HasSubstr("max_depth_mm"));
  EXPECT_THAT(Error("type: depth_camera\nprinciple: sonar\n"), HasSubstr("time_of_flight"));
  EXPECT_THAT(Error("type: depth_camera\nplace: {x_mm: 1}\n"), HasSubstr("look_x_mm"));
  EXPECT_THAT(Error("type: depth_camera\nsite: a\nplace: {x_mm: 1}\n"), HasSubstr("site"));
  EXPECT_THAT(testing_support::ErrorOf(
                  [&] { ReadRangeSensor(folder_.Write("stereo.yaml", "type: stereo_camera\n")); }),
              HasSubstr("depth_camera"));
}

}  // namespace
}  // namespace rangegrasp::sensing
