#include "stereo/camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "base/error.h"
#include "base/file.h"
#include "base/rng.h"
#include "error_of.h"
#include "synthetic_pair.h"
#include "temp_folder.h"

namespace rangegrasp::stereo {
namespace {

using testing::HasSubstr;
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
      calibration.X_WL * Eigen::Vector3d(0.021, -0.001, 0.002));
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
    // Both compute in double precision, so 2,000 px are exact to 1e-9 px.
    EXPECT_NEAR(pixel.x(), pixels[0].x, 1e-9);
    EXPECT_NEAR(pixel.y(), pixels[0].y, 1e-9);
  }
}

// Equations 5.10 to 5.12 computed by hand, one coefficient at a time, which reveals swapped ones.
// At (0.3, -0.2) r^2 is 0.13, r^4 is 0.0169 and r^6 is 0.002197.
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
  // x (1 - 0.5 x^2) is never above 0.545, so no point is seen at 0.6.
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

// The error message of reading a file in which `from` is replaced by `to`.
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
  const auto names = [](const std::string& what) {
    return testing::AllOf(HasSubstr("stereo.yaml"), HasSubstr(what));
  };
  EXPECT_THAT(ErrorAfter("width_px:", ""), names("width_px"));
  EXPECT_THAT(ErrorAfter("fx_px:", "fx_px: -3"), names("fx_px"));
  EXPECT_THAT(ErrorAfter("k1:", "k_1: 0.1"), names("k1"));
  EXPECT_THAT(ErrorAfter("cx_px:", "cx_px: 1700"), names("principal point"));
  EXPECT_THAT(ErrorAfter("qw:", "qw: 0.99"), names("quaternion"));
  EXPECT_THAT(ErrorAfter("right:", "rihgt:"), names("right"));
}

TEST(StereoCalibrationFile, OnePlaceForBothPicturesIsNoPair) {
  const TempFolder folder;
  StereoCalibration calibration = SampleCalibration();
  calibration.X_WR = calibration.X_WL;
  WriteStereoCalibration(calibration, folder / "stereo.yaml");
  EXPECT_THAT(ErrorOf([&] { ReadStereoCalibration(folder / "stereo.yaml"); }),
              HasSubstr("same position"));
}

TEST(StereoCalibrationFile, CamerasThatAreNotSideBySideAreRefusedByName) {
  const TempFolder folder;
  const auto error_at = [&](const Eigen::Vector3d& right_L) {
    StereoCalibration calibration = SampleCalibration();
    calibration.X_WR.translation() = calibration.X_WL * right_L;
    WriteStereoCalibration(calibration, folder / "stereo.yaml");
    return ErrorOf([&] { ReadStereoCalibration(folder / "stereo.yaml"); });
  };
  EXPECT_THAT(error_at({0.01, 0.02, 0.0}), HasSubstr("stereo.yaml: one camera is above the other"));
  EXPECT_THAT(error_at({-0.02, 0.01, 0.0}), HasSubstr("stereo.yaml: the right camera is 20.0 mm"));
}

using testing_support::SyntheticCalibration;

// The pixel of a point in a rectified picture, computed from its pixel in the original picture.
Eigen::Vector2d RectifiedPixel(const Camera& camera, const RectifiedCameras& cameras,
                               const base::Pose& X_WC, const Eigen::Matrix3d& R_CS,
                               const Eigen::Vector3d& p_W) {
  const Eigen::Vector2d taken = Project(camera, X_WC.inverse() * p_W);
  const Eigen::Vector3d ray_S = R_CS.transpose() * RayOf(camera, taken);
  return {cameras.f * ray_S.x() / ray_S.z() + cameras.cx,
          cameras.f * ray_S.y() / ray_S.z() + cameras.cy};
}

Eigen::Vector3d PlaceOnTable(base::Rng& rng) {
  const double x = rng.Uniform(-0.1, 0.1);
  const double y = rng.Uniform(-0.15, 0.15);
  const double z = rng.Uniform(0.0, 0.15);
  return {x, y, z};
}

TEST(Rectify, KnownPointsStandInOneRowAndAreTriangulatedWhereTheyAre) {
  const StereoCalibration calibration = SyntheticCalibration();
  const RectifiedCameras cameras = Rectify(calibration);
  base::Rng rng(1);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d p_W = PlaceOnTable(rng);
    const Eigen::Vector2d left =
        RectifiedPixel(calibration.camera, cameras, calibration.X_WL, cameras.R_LS, p_W);
    const Eigen::Vector2d right =
        RectifiedPixel(calibration.camera, cameras, calibration.X_WR, cameras.R_RS, p_W);
    EXPECT_NEAR(left.y(), right.y(), 1e-6);
    EXPECT_GT(left.x(), right.x());
    EXPECT_LT((cameras.Triangulate(left.x(), left.y(), left.x() - right.x()) - p_W).norm(), 1e-6);
  }
}

TEST(Rectify, TriangulatesAsOpenCvDoes) {
  const StereoCalibration calibration = SyntheticCalibration();
  const RectifiedCameras cameras = Rectify(calibration);
  const cv::Mat left_projection = (cv::Mat_<double>(3, 4) << cameras.f, 0, cameras.cx, 0, 0,
                                   cameras.f, cameras.cy, 0, 0, 0, 1, 0);
  cv::Mat right_projection = left_projection.clone();
  right_projection.at<double>(0, 3) = -cameras.f * cameras.baseline_m;
  base::Rng rng(2);
  for (int i = 0; i < 200; ++i) {
    const double x = rng.Uniform(100.0, 300.0);
    const double y = rng.Uniform(50.0, 250.0);
    const double disparity = rng.Uniform(20.0, 60.0);
    const cv::Mat left = (cv::Mat_<double>(2, 1) << x, y);
    const cv::Mat right = (cv::Mat_<double>(2, 1) << x - disparity, y);
    cv::Mat homogeneous;
    cv::triangulatePoints(left_projection, right_projection, left, right, homogeneous);
    const double* h = homogeneous.ptr<double>(0);
    const Eigen::Vector3d p_S = Eigen::Vector3d(h[0], h[1], h[2]) / h[3];
    EXPECT_LT((cameras.Triangulate(x, y, disparity) - cameras.X_WS * p_S).norm(), 1e-6);
  }
}

// OpenCV rectifies a pixel of the original picture, given the coefficients, rotation and projection
// one by one. LeftSource must lead from the rectified place back to the original pixel.
TEST(Rectifier, RectifiesPointsAsOpenCvDoes) {
  const StereoCalibration calibration = SyntheticCalibration();
  const Rectifier rectifier(calibration);
  const RectifiedCameras& cameras = rectifier.cameras();
  const Camera& c = calibration.camera;
  const cv::Matx33d matrix(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  const cv::Matx33d projection(cameras.f, 0, cameras.cx, 0, cameras.f, cameras.cy, 0, 0, 1);
  const cv::Vec<double, 5> distortion(c.k1, c.k2, c.p1, c.p2, c.k3);
  const Eigen::Matrix3d R = cameras.R_LS.transpose();
  const cv::Matx33d turn(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1),
                         R(2, 2));
  const cv::TermCriteria until_still(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-12);
  base::Rng rng(4);
  for (int i = 0; i < 1000; ++i) {
    const double x = rng.Uniform(0.0, 399.0);
    const double y = rng.Uniform(0.0, 299.0);
    const std::vector<cv::Point2d> taken = {{x, y}};
    std::vector<cv::Point2d> rectified;
    cv::undistortPoints(taken, rectified, matrix, distortion, turn, projection, until_still);
    const Eigen::Vector2d source = rectifier.LeftSource(rectified[0].x, rectified[0].y);
    EXPECT_NEAR(source.x(), x, 1e-6);
    EXPECT_NEAR(source.y(), y, 1e-6);
  }
}

TEST(Rectifier, TakesEachPixelFromWhereItSaysAndUndoesDistortionAsTheCameraMadeIt) {
  // The coefficients are so large that swapping any two moves some pixel by more than a few pixels.
  StereoCalibration calibration = SyntheticCalibration();
  Camera& camera = calibration.camera;
  camera.k1 = -0.15;
  camera.k2 = 0.2;
  camera.p1 = 0.02;
  camera.p2 = -0.015;
  camera.k3 = 0.6;
  const Rectifier rectifier(calibration);
  // A picture whose red encodes the column and whose green encodes the row, in its middle.
  constexpr int kLeft = 72, kTop = 22, kMost = 255;
  image::Image ramp{400, 300, {}};
  const auto level = [&](int place) {
    return static_cast<std::uint8_t>(std::clamp(place, 0, kMost));
  };
  for (int y = 0; y < ramp.height; ++y) {
    for (int x = 0; x < ramp.width; ++x) {
      ramp.rgb.insert(ramp.rgb.end(), {level(x - kLeft), level(y - kTop), 200});
    }
  }
  const PicturePair pair = rectifier.Apply(ramp, ramp);
  int compared = 0;
  for (int y = 0; y < 300; y += 5) {
    for (int x = 0; x < 400; x += 5) {
      const Eigen::Vector2d place =
          rectifier.LeftSource(x, y) - Eigen::Vector2d(double{kLeft}, double{kTop});
      if (place.minCoeff() < 1.0 || place.maxCoeff() > kMost - 1.0) continue;
      const std::uint8_t* pixel = pair.left.At(x, y);
      // A level is rounded by up to a half, and OpenCV's place by a 32nd of a pixel in x and y.
      EXPECT_NEAR(pixel[0], place.x(), 0.5 + 1.0 / 32.0);
      EXPECT_NEAR(pixel[1], place.y(), 0.5 + 1.0 / 32.0);
      ++compared;
    }
  }
  EXPECT_GT(compared, 1000);
}

TEST(Rectifier, RefusesPicturesOfAnotherCamera) {
  const Rectifier rectifier(SyntheticCalibration());
  const image::Image right_size{400, 300, std::vector<std::uint8_t>(3 * 400 * 300)};
  const image::Image other{300, 400, std::vector<std::uint8_t>(3 * 400 * 300)};
  EXPECT_THAT(ErrorOf([&] { rectifier.Apply(right_size, other); }),
              HasSubstr("right picture has 300 x 400"));
}

TEST(Rectify, ExchangedPicturesAreNamed) {
  StereoCalibration calibration = SyntheticCalibration();
  std::swap(calibration.X_WL, calibration.X_WR);
  EXPECT_THAT(ErrorOf([&] { Rectify(calibration); }), HasSubstr("exchange"));
}

}  // namespace
}  // namespace rangegrasp::stereo
