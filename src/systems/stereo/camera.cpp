#include "stereo/camera.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/file.h"
#include "base/units.h"
#include "sensing/hand_eye.h"
#include "stereo/internal/open_cv.h"

namespace rangegrasp::stereo {
namespace {

namespace fs = std::filesystem;

// Limits for files: far beyond any camera, but low enough to detect a wrong unit.
constexpr int kMaxSize_px = 16384;
constexpr double kMaxFocalLength_px = 1e6;
constexpr double kMaxDistortion = 100.0;
// Below this, both pictures are from the same position.
constexpr double kMinBaseline_m = 1e-4;

Eigen::Vector2d NoPoint() {
  return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
}

// The derivative of Distort.
Eigen::Matrix2d DistortionSlope(const Camera& c, const Eigen::Vector2d& p) {
  const double x = p.x(), y = p.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
  const double radial_slope = 2.0 * (c.k1 + r2 * (2.0 * c.k2 + r2 * 3.0 * c.k3));  // times x or y
  Eigen::Matrix2d slope;
  const double mixed = x * y * radial_slope + 2.0 * c.p1 * x + 2.0 * c.p2 * y;
  slope << radial + x * x * radial_slope + 2.0 * c.p1 * y + 6.0 * c.p2 * x, mixed, mixed,
      radial + y * y * radial_slope + 2.0 * c.p2 * x + 6.0 * c.p1 * y;
  return slope;
}

/// Checks that cameras and poses can see one scene; `name` is the calibration's name in errors.
void CheckCalibration(const StereoCalibration& calibration, const std::string& name) {
  const auto refuse = [&](const std::string& why) { throw base::InputError(name + ": " + why); };
  const Camera& c = calibration.camera;
  if (c.width < 1 || c.height < 1 || c.width > kMaxSize_px || c.height > kMaxSize_px) {
    refuse(fmt::format("a camera of {} x {} pixels", c.width, c.height));
  }
  if (!(c.fx > 0.0 && c.fy > 0.0) || !std::isfinite(c.fx) || !std::isfinite(c.fy)) {
    refuse(fmt::format("the focal lengths are {} and {} px; they must be finite and above 0", c.fx,
                       c.fy));
  }
  if (!(c.cx >= 0.0 && c.cx < c.width && c.cy >= 0.0 && c.cy < c.height)) {
    refuse(
        fmt::format("the principal point ({:.1f}, {:.1f}) is not in the picture of {} x {} pixels",
                    c.cx, c.cy, c.width, c.height));
  }
  const double baseline = (calibration.X_WR.translation() - calibration.X_WL.translation()).norm();
  if (!(baseline >= kMinBaseline_m)) {
    refuse(fmt::format(
        "left and right have the same position ({:.4f} mm apart): triangulation is impossible",
        baseline * base::kMmPerM));
  }
  const Eigen::Vector3d right_L = RightInLeft(calibration).translation();
  if (std::abs(right_L.x()) < std::abs(right_L.y())) {
    refuse("one camera is above the other; they must be side by side");
  }
  if (right_L.x() <= 0.0) {
    refuse(
        fmt::format("the right camera is {:.1f} mm to the left of the left one; exchange the two",
                    -right_L.x() * base::kMmPerM));
  }
}

}  // namespace

Eigen::Vector2d Distort(const Camera& c, const Eigen::Vector2d& undistorted) {
  const double x = undistorted.x(), y = undistorted.y();
  const double r2 = x * x + y * y;
  const double radial = r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
  return {x + x * radial + 2.0 * c.p1 * x * y + c.p2 * (r2 + 2.0 * x * x),
          y + y * radial + 2.0 * c.p2 * x * y + c.p1 * (r2 + 2.0 * y * y)};
}

Eigen::Vector2d Undistort(const Camera& camera, const Eigen::Vector2d& distorted) {
  // Quadratic convergence: for a lens, 3 or 4 steps reach rounding errors.
  constexpr int kMaxSteps = 20;
  constexpr double kTolerance = 1e-13;
  Eigen::Vector2d p = distorted;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Vector2d error = Distort(camera, p) - distorted;
    if (error.norm() < kTolerance * (1.0 + distorted.norm())) return p;
    const Eigen::Matrix2d slope = DistortionSlope(camera, p);
    // Beyond the fold of the distortion two points have one image.
    if (!(slope.determinant() > 0.0)) return NoPoint();
    p -= slope.inverse() * error;
  }
  return NoPoint();
}

Eigen::Vector2d Project(const Camera& camera, const Eigen::Vector3d& p_S) {
  if (!(p_S.z() > 0.0)) return NoPoint();
  const Eigen::Vector2d d = Distort(camera, p_S.head<2>() / p_S.z());
  return {camera.fx * d.x() + camera.cx, camera.fy * d.y() + camera.cy};
}

Eigen::Vector3d RayOf(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d p =
      Undistort(camera, {(pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy});
  return {p.x(), p.y(), 1.0};
}

const std::uint8_t* NearestPixel(const image::Image& picture, const Eigen::Vector2d& place) {
  return picture.At(
      static_cast<int>(std::clamp<long>(std::lround(place.x()), 0, picture.width - 1)),
      static_cast<int>(std::clamp<long>(std::lround(place.y()), 0, picture.height - 1)));
}

base::Pose RightInLeft(const StereoCalibration& calibration) {
  return calibration.X_WL.inverse() * calibration.X_WR;
}

StereoCalibration ReadStereoCalibration(const fs::path& file) {
  auto map = base::YamlMap::FromFile(file);
  StereoCalibration calibration;
  map.Require("camera");
  auto camera = map.Child("camera", "pinhole camera with the distortion of equations 5.10 to 5.12");
  ReadCamera(camera, calibration.camera);
  calibration.X_WL = sensing::ReadPoseOf(map, "left");
  calibration.X_WR = sensing::ReadPoseOf(map, "right");
  map.Read("reprojection_px", calibration.reprojection_px, 0.0, 1e3,
           "residual of the camera's calibration; 0: unknown");
  map.ReadScaled("registration_mm", calibration.registration_m, base::kMm, 0.0, 1e3,
                 "residual of the registration to the arm; 0: unknown");
  map.Finish();
  CheckCalibration(calibration, file.string());
  return calibration;
}

void WriteStereoCalibration(const StereoCalibration& calibration, const fs::path& file) {
  base::WriteFile(
      file, fmt::format("# One camera that takes two pictures: its model, and its pose in the "
                        "arm's frame at each.\n# Axes of the camera: x right, y down, z "
                        "forward.\n{}{}{}reprojection_px: {:.17g}\nregistration_mm: {:.17g}\n",
                        CameraText("camera", calibration.camera),
                        sensing::PoseText("left", calibration.X_WL),
                        sensing::PoseText("right", calibration.X_WR), calibration.reprojection_px,
                        calibration.registration_m * base::kMmPerM));
}

void ReadCamera(base::YamlMap& map, Camera& camera) {
  const auto read = [&](const char* key, auto& value, auto low, auto high, const char* doc) {
    map.Require(key);
    map.Read(key, value, low, high, doc);
  };
  read("width_px", camera.width, 1, kMaxSize_px, "width of its pictures");
  read("height_px", camera.height, 1, kMaxSize_px, "height of its pictures");
  read("fx_px", camera.fx, 1.0, kMaxFocalLength_px, "focal length along a row");
  read("fy_px", camera.fy, 1.0, kMaxFocalLength_px, "focal length along a column");
  read("cx_px", camera.cx, 0.0, kMaxSize_px, "column of the principal point");
  read("cy_px", camera.cy, 0.0, kMaxSize_px, "row of the principal point");
  const auto distortion = [&](const char* key, double& value, const char* doc) {
    map.Read(key, value, -kMaxDistortion, kMaxDistortion, doc);
  };
  distortion("k1", camera.k1, "radial distortion, of r^2 (equation 5.10)");
  distortion("k2", camera.k2, "radial distortion, of r^4");
  distortion("k3", camera.k3, "radial distortion, of r^6; not in the dissertation");
  distortion("p1", camera.p1, "tangential distortion");
  distortion("p2", camera.p2, "tangential distortion");
  map.Finish();
}

std::string CameraText(const std::string& name, const Camera& c) {
  return fmt::format(
      "{}:\n  width_px: {}\n  height_px: {}\n  fx_px: {:.17g}\n  fy_px: {:.17g}\n  cx_px: "
      "{:.17g}\n  cy_px: {:.17g}\n  k1: {:.17g}\n  k2: {:.17g}\n  p1: {:.17g}\n  p2: {:.17g}\n  "
      "k3: {:.17g}\n",
      name, c.width, c.height, c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3);
}

struct Rectifier::Maps {
  // Places and their fractions in OpenCV's own packed form, which is twice as fast to apply.
  struct Map {
    cv::Mat places, fractions;
  } left, right;
};

RectifiedCameras Rectify(const StereoCalibration& calibration) {
  CheckCalibration(calibration, "the stereo calibration");
  const base::Pose X_LR = RightInLeft(calibration);
  const base::Pose X_RL = X_LR.inverse();  // equations 5.13 and 5.14
  const Camera& camera = calibration.camera;
  const cv::Matx33d matrix = internal::MatrixOf(camera);
  const cv::Vec<double, 5> distortion = internal::DistortionOf(camera);
  const cv::Size size(camera.width, camera.height);
  cv::Matx33d to_left, to_right;
  cv::Matx34d left_projection, right_projection;
  cv::Matx44d unused;
  cv::stereoRectify(matrix, distortion, matrix, distortion, size,
                    internal::FromEigen(X_RL.rotation()), internal::ShiftOf(X_RL), to_left,
                    to_right, left_projection, right_projection, unused, cv::CALIB_ZERO_DISPARITY);
  const Eigen::Matrix3d R_LS = internal::ToEigen(to_left).transpose();
  return {
      .width = camera.width,
      .height = camera.height,
      .f = left_projection(0, 0),
      .cx = left_projection(0, 2),
      .cy = left_projection(1, 2),
      .baseline_m = X_LR.translation().norm(),
      .X_WS = base::MakePose(calibration.X_WL.rotation() * R_LS, calibration.X_WL.translation()),
      .R_LS = R_LS,
      .R_RS = internal::ToEigen(to_right).transpose()};
}

Rectifier::Rectifier(const StereoCalibration& calibration)
    : camera_(calibration.camera), cameras_(Rectify(calibration)) {
  const internal::SingleThread single;
  auto maps = std::make_shared<Maps>();
  const cv::Matx33d projection(cameras_.f, 0.0, cameras_.cx, 0.0, cameras_.f, cameras_.cy, 0.0, 0.0,
                               1.0);
  const cv::Size size(cameras_.width, cameras_.height);
  const auto fill = [&](const Eigen::Matrix3d& R_camera, Maps::Map& map) {
    cv::initUndistortRectifyMap(internal::MatrixOf(camera_), internal::DistortionOf(camera_),
                                internal::FromEigen(R_camera.transpose()), projection, size,
                                CV_16SC2, map.places, map.fractions);
  };
  fill(cameras_.R_LS, maps->left);
  fill(cameras_.R_RS, maps->right);
  maps_ = std::move(maps);
}

PicturePair Rectifier::Apply(const image::Image& left, const image::Image& right) const {
  const internal::SingleThread single;
  const auto turned = [&](const image::Image& from, const char* name, const Maps::Map& map) {
    if (from.width != camera_.width || from.height != camera_.height) {
      throw base::InputError(
          fmt::format("the {} picture has {} x {} pixels, the camera of the calibration {} x {}: "
                      "it is from another camera",
                      name, from.width, from.height, camera_.width, camera_.height));
    }
    image::Image to;
    cv::Mat room = internal::Room(cameras_.width, cameras_.height, to);
    cv::remap(internal::View(from), room, map.places, map.fractions, cv::INTER_LINEAR,
              cv::BORDER_CONSTANT);
    return to;
  };
  return {turned(left, "left", maps_->left), turned(right, "right", maps_->right)};
}

Eigen::Vector2d Rectifier::LeftSource(double x, double y) const {
  return Project(camera_, cameras_.R_LS * cameras_.RayAt(x, y));
}

}  // namespace rangegrasp::stereo
