#include "stereo/rectify.h"

#include <fmt/format.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "base/error.h"
#include "base/units.h"
#include "stereo/internal/open_cv.h"

namespace rangegrasp::stereo {
namespace {

void CheckOrRefuse(const StereoCalibration& calibration) {
  try {
    CheckCalibration(calibration);
  } catch (const std::invalid_argument& error) {
    throw base::InputError(std::string("the stereo calibration: ") + error.what());
  }
}

// Left and right are beside each other, seen from the left camera.
void CheckSides(const Eigen::Vector3d& right_L) {
  const double sideways = right_L.x();
  if (std::abs(sideways) < std::abs(right_L.y())) {
    throw base::InputError(
        "the stereo calibration: one camera stands above the other, not beside it");
  }
  if (sideways <= 0.0) {
    throw base::InputError(fmt::format(
        "the stereo calibration: the right camera stands {:.1f} mm to the left of the left one; "
        "exchange the two",
        -sideways * base::kMmPerM));
  }
}

}  // namespace

struct Rectifier::Maps {
  // Places and their fractions in OpenCV's own packed form, which is twice as fast to apply.
  cv::Mat left_places, left_fractions, right_places, right_fractions;
};

Eigen::Vector3d RectifiedCameras::Triangulate(double x, double y, double disparity) const {
  const double z = f * baseline_m / disparity;
  return X_WS * Eigen::Vector3d((x - cx) / f * z, (y - cy) / f * z, z);
}

RectifiedCameras Rectify(const StereoCalibration& calibration) {
  CheckOrRefuse(calibration);
  const base::Pose X_LR = RightInLeft(calibration);
  CheckSides(X_LR.translation());
  const base::Pose X_RL = X_LR.inverse();  // equations 5.13 and 5.14
  const Eigen::Vector3d t = X_RL.translation();
  const Camera& camera = calibration.camera;
  const cv::Matx33d matrix = internal::MatrixOf(camera);
  const cv::Vec<double, 5> distortion = internal::DistortionOf(camera);
  const cv::Size size(camera.width, camera.height);
  cv::Matx33d to_left, to_right;
  cv::Matx34d left_projection, right_projection;
  cv::Matx44d unused;
  cv::stereoRectify(matrix, distortion, matrix, distortion, size,
                    internal::FromEigen(X_RL.rotation()), cv::Vec3d(t.x(), t.y(), t.z()), to_left,
                    to_right, left_projection, right_projection, unused, cv::CALIB_ZERO_DISPARITY);
  RectifiedCameras cameras;
  cameras.width = camera.width;
  cameras.height = camera.height;
  cameras.f = left_projection(0, 0);
  cameras.cx = left_projection(0, 2);
  cameras.cy = left_projection(1, 2);
  cameras.baseline_m = X_LR.translation().norm();
  cameras.R_LS = internal::ToEigen(to_left).transpose();
  cameras.R_RS = internal::ToEigen(to_right).transpose();
  cameras.X_WS =
      base::MakePose(calibration.X_WL.rotation() * cameras.R_LS, calibration.X_WL.translation());
  return cameras;
}

Rectifier::Rectifier(const StereoCalibration& calibration)
    : camera_(calibration.camera), cameras_(Rectify(calibration)) {
  const internal::SingleThread single;
  auto maps = std::make_unique<Maps>();
  const cv::Matx33d projection(cameras_.f, 0.0, cameras_.cx, 0.0, cameras_.f, cameras_.cy, 0.0, 0.0,
                               1.0);
  const cv::Size size(cameras_.width, cameras_.height);
  const auto fill = [&](const Eigen::Matrix3d& R_camera, cv::Mat& places, cv::Mat& fractions) {
    cv::initUndistortRectifyMap(internal::MatrixOf(camera_), internal::DistortionOf(camera_),
                                internal::FromEigen(R_camera.transpose()), projection, size,
                                CV_16SC2, places, fractions);
  };
  fill(cameras_.R_LS, maps->left_places, maps->left_fractions);
  fill(cameras_.R_RS, maps->right_places, maps->right_fractions);
  maps_ = std::move(maps);
}

Rectifier::~Rectifier() = default;
Rectifier::Rectifier(Rectifier&&) noexcept = default;

RectifiedPair Rectifier::Apply(const image::Image& left, const image::Image& right) const {
  const auto check = [&](const image::Image& picture, const char* name) {
    if (picture.width == camera_.width && picture.height == camera_.height) return;
    throw base::InputError(fmt::format(
        "the {} picture has {} x {} pixels, the camera of the calibration {} x {}: it is another "
        "camera's",
        name, picture.width, picture.height, camera_.width, camera_.height));
  };
  check(left, "left");
  check(right, "right");
  const internal::SingleThread single;
  RectifiedPair pair;
  const auto turn = [&](const image::Image& from, const cv::Mat& places, const cv::Mat& fractions,
                        image::Image& to) {
    cv::Mat room = internal::Room(cameras_.width, cameras_.height, to);
    cv::remap(internal::View(from), room, places, fractions, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  };
  turn(left, maps_->left_places, maps_->left_fractions, pair.left);
  turn(right, maps_->right_places, maps_->right_fractions, pair.right);
  return pair;
}

Eigen::Vector2d Rectifier::LeftSource(double x, double y) const {
  const Eigen::Vector3d ray_S((x - cameras_.cx) / cameras_.f, (y - cameras_.cy) / cameras_.f, 1.0);
  return Project(camera_, cameras_.R_LS * ray_S);
}

}  // namespace rangegrasp::stereo
