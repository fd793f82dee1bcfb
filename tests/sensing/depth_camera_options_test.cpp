#include "sensing/range_sensor_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "error_of.h"
#include "sensing/depth_camera.h"
#include "sensing/range_sensor.h"
#include "temp_folder.h"

namespace rangegrasp::sensing {
namespace {

using ::testing::HasSubstr;

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
