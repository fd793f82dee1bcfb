#include "stereo/rectify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/calib3d.hpp>

#include "base/rng.h"
#include "error_of.h"
#include "synthetic_pair.h"

namespace rangegrasp::stereo {
namespace {

using testing_support::ErrorOf;
using testing_support::SyntheticCalibration;

// Where a point stands in a rectified picture: from the pixel of the picture as it was taken.
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

// Where OpenCV moves a pixel of the picture as it was taken, coefficients, rotation and projection
// given to it one by one, and where LeftSource takes that place from.
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
  // So much of each coefficient that any two exchanged move some pixel by more than a few.
  StereoCalibration calibration = SyntheticCalibration();
  Camera& camera = calibration.camera;
  camera.k1 = -0.15;
  camera.k2 = 0.2;
  camera.p1 = 0.02;
  camera.p2 = -0.015;
  camera.k3 = 0.6;
  const Rectifier rectifier(calibration);
  // A picture whose red is its column and whose green is its row, in the middle of it.
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
  const RectifiedPair pair = rectifier.Apply(ramp, ramp);
  int compared = 0;
  for (int y = 0; y < 300; y += 5) {
    for (int x = 0; x < 400; x += 5) {
      const Eigen::Vector2d place =
          rectifier.LeftSource(x, y) - Eigen::Vector2d(double{kLeft}, double{kTop});
      if (place.minCoeff() < 1.0 || place.maxCoeff() > kMost - 1.0) continue;
      const std::uint8_t* pixel = pair.left.At(x, y);
      // A level is rounded to a half, OpenCV's place of it to a 32nd of a pixel both ways.
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
  const std::string message = ErrorOf([&] { rectifier.Apply(right_size, other); });
  EXPECT_NE(message.find("right picture has 300 x 400"), std::string::npos) << message;
}

TEST(Rectify, ExchangedPicturesAreNamed) {
  StereoCalibration calibration = SyntheticCalibration();
  std::swap(calibration.X_WL, calibration.X_WR);
  const std::string message = ErrorOf([&] { Rectify(calibration); });
  EXPECT_NE(message.find("exchange"), std::string::npos) << message;
}

}  // namespace
}  // namespace rangegrasp::stereo
