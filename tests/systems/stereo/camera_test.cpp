#include "stereo/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>

#include "base/error.h"
#include "base/file.h"
#include "base/rng.h"
#include "base/units.h"
#include "error_of.h"
#include "temp_folder.h"

namespace rangegrasp::stereo {
namespace {

using testing_support::ErrorOf;
using testing_support::TempFolder;

Camera SampleCamera() {
  return {1600, 1200, 2010.0, 1995.0, 812.0, 590.0, -0.12, 0.08, 1e-3, -6e-4, 0.02};
}

StereoCalibration SampleCalibration() {
  StereoCalibration calibration;
  calibration.camera = SampleCamera();
  calibration.X_WL = base::MakePose(
      Eigen::AngleAxisd(2.3, Eigen::Vector3d(1, 0.3, -0.2).normalized()).toRotationMatrix(),
      {0.7, -0.02, 0.9});
  calibration.X_WR = base::MakePose(
      Eigen::AngleAxisd(2.2, Eigen::Vector3d(1, 0.3, -0.2).normalized()).toRotationMatrix(),
      {0.7, 0.001, 0.9});
  calibration.reprojection_px = 0.21;
  calibration.registration_m = 0.0011;
  return calibration;
}

cv::Mat MatrixOf(const Camera& c) {
  return (cv::Mat_<double>(3, 3) << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
}

Eigen::Vector3d SeenPoint(base::Rng& rng) {
  const double z = rng.Uniform(0.5, 2.0);
  const double x = rng.Uniform(-0.4, 0.4) * z;
  const double y = rng.Uniform(-0.3, 0.3) * z;
  return {x, y, z};
}

TEST(Camera, ProjectsAsOpenCvDoes) {
  const Camera camera = SampleCamera();
  const cv::Vec<double, 5> distortion(camera.k1, camera.k2, camera.p1, camera.p2, camera.k3);
  base::Rng rng(1);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d p = SeenPoint(rng);
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(std::vector<cv::Point3d>{{p.x(), p.y(), p.z()}}, cv::Vec3d(0, 0, 0),
                      cv::Vec3d(0, 0, 0), MatrixOf(camera), distortion, pixels);
    const Eigen::Vector2d pixel = Project(camera, p);
    // Both compute in double precision: 1e-9 px of 2,000.
    EXPECT_NEAR(pixel.x(), pixels[0].x, 1e-9);
    EXPECT_NEAR(pixel.y(), pixels[0].y, 1e-9);
  }
}

// Equations 5.10 to 5.12 by hand, one coefficient at a time: exchanged ones show. At (0.3, -0.2)
// r^2 is 0.13, r^4 0.0169 and r^6 0.002197.
TEST(Camera, EachCoefficientMovesAPointAsItsEquationSays) {
  const Eigen::Vector2d p(0.3, -0.2);
  const auto moved = [&](double Camera::*coefficient) {
    Camera camera;
    camera.*coefficient = 1.0;
    return Eigen::Vector2d(Distort(camera, p) - p);
  };
  const auto expect = [](const Eigen::Vector2d& by, double x, double y) {
    EXPECT_NEAR(by.x(), x, 1e-15);
    EXPECT_NEAR(by.y(), y, 1e-15);
  };
  expect(moved(&Camera::k1), 0.3 * 0.13, -0.2 * 0.13);
  expect(moved(&Camera::k2), 0.3 * 0.0169, -0.2 * 0.0169);
  expect(moved(&Camera::k3), 0.3 * 0.002197, -0.2 * 0.002197);
  expect(moved(&Camera::p1), 2 * 0.3 * -0.2, 0.13 + 2 * 0.04);  // 2 x y and r^2 + 2 y^2
  expect(moved(&Camera::p2), 0.13 + 2 * 0.09, 2 * 0.3 * -0.2);  // r^2 + 2 x^2 and 2 x y
}

TEST(Camera, RayThroughAPixelMeetsThePointThatIsSeenThere) {
  const Camera camera = SampleCamera();
  base::Rng rng(2);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d p = SeenPoint(rng);
    const Eigen::Vector3d ray = RayOf(camera, Project(camera, p));
    EXPECT_LT((ray * p.z() - p).norm(), 1e-11);
  }
}

TEST(Camera, SeesNothingBehindItAndNothingBeyondTheFoldOfItsDistortion) {
  Camera camera = SampleCamera();
  EXPECT_TRUE(std::isnan(Project(camera, {0.1, 0.1, -1.0}).x()));
  EXPECT_TRUE(std::isnan(Project(camera, {0.1, 0.1, 0.0}).x()));
  // x (1 - 0.5 x^2) is never above 0.545: no point is seen at 0.6.
  camera = {100, 100, 100.0, 100.0, 50.0, 50.0, -0.5};
  EXPECT_NEAR(Undistort(camera, {0.4375, 0.0}).x(), 0.5, 1e-12);
  EXPECT_TRUE(std::isnan(Undistort(camera, {0.6, 0.0}).x()));
}

TEST(StereoCalibrationFile, IsReadAsItWasWritten) {
  const TempFolder folder;
  const StereoCalibration written = SampleCalibration();
  WriteStereoCalibration(written, folder / "stereo.yaml");
  const StereoCalibration read = ReadStereoCalibration(folder / "stereo.yaml");
  EXPECT_EQ(read.camera, written.camera);
  EXPECT_TRUE(read.X_WL.isApprox(written.X_WL, 1e-14));
  EXPECT_TRUE(read.X_WR.isApprox(written.X_WR, 1e-14));
  EXPECT_DOUBLE_EQ(read.reprojection_px, written.reprojection_px);
  EXPECT_DOUBLE_EQ(read.registration_m, written.registration_m);
}

// The message that reading gives once `from` stands as `to` in the file.
std::string ErrorAfter(const std::string& from, const std::string& to) {
  const TempFolder folder;
  const auto file = folder / "stereo.yaml";
  WriteStereoCalibration(SampleCalibration(), file);
  std::string text = base::ReadFile(file);
  const auto place = text.find(from);
  EXPECT_NE(place, std::string::npos);
  text.replace(place, text.find('\n', place) - place, to);
  base::WriteFile(file, text);
  return ErrorOf([&] { ReadStereoCalibration(file); });
}

TEST(StereoCalibrationFile, WhatIsWrongInItIsNamed) {
  const auto names = [](const std::string& message, const std::string& what) {
    return message.find("stereo.yaml") != std::string::npos &&
           message.find(what) != std::string::npos;
  };
  EXPECT_PRED2(names, ErrorAfter("width_px:", ""), "width_px");
  EXPECT_PRED2(names, ErrorAfter("fx_px:", "fx_px: -3"), "fx_px");
  EXPECT_PRED2(names, ErrorAfter("k1:", "k_1: 0.1"), "k1");
  EXPECT_PRED2(names, ErrorAfter("cx_px:", "cx_px: 1700"), "principal point");
  EXPECT_PRED2(names, ErrorAfter("qw:", "qw: 0.99"), "quaternion");
  EXPECT_PRED2(names, ErrorAfter("right:", "rihgt:"), "right");
}

TEST(StereoCalibrationFile, OnePlaceForBothPicturesIsNoPair) {
  const TempFolder folder;
  StereoCalibration calibration = SampleCalibration();
  calibration.X_WR = calibration.X_WL;
  WriteStereoCalibration(calibration, folder / "stereo.yaml");
  const std::string message = ErrorOf([&] { ReadStereoCalibration(folder / "stereo.yaml"); });
  EXPECT_NE(message.find("one place"), std::string::npos) << message;
}

}  // namespace
}  // namespace rangegrasp::stereo
