#include "stereo/camera.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "base/error.h"
#include "base/file.h"
#include "base/units.h"
#include "base/yaml_map.h"
#include "sensing/hand_eye.h"
#include "stereo/internal/camera_file.h"

namespace rangegrasp::stereo {
namespace {

// Far beyond any camera.
constexpr int kMaxSize_px = 16384;
// Below this the two pictures are one.
constexpr double kMinBaseline_m = 1e-4;

constexpr char kFrame[] = "of the camera in the arm's frame";

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Eigen::Vector2d NoPoint() { return {kNaN, kNaN}; }

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

}  // namespace

Eigen::Vector2d Distort(const Camera& c, const Eigen::Vector2d& undistorted) {
  const double x = undistorted.x(), y = undistorted.y();
  const double r2 = x * x + y * y;
  const double radial = r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
  return {x + x * radial + 2.0 * c.p1 * x * y + c.p2 * (r2 + 2.0 * x * x),
          y + y * radial + 2.0 * c.p2 * x * y + c.p1 * (r2 + 2.0 * y * y)};
}

Eigen::Vector2d Undistort(const Camera& camera, const Eigen::Vector2d& distorted) {
  // Quadratic convergence: a lens' distortion takes 3 or 4 steps to rounding.
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

base::Pose RightInLeft(const StereoCalibration& calibration) {
  return calibration.X_WL.inverse() * calibration.X_WR;
}

void CheckCalibration(const StereoCalibration& calibration) {
  const Camera& c = calibration.camera;
  if (c.width < 1 || c.height < 1 || c.width > kMaxSize_px || c.height > kMaxSize_px) {
    throw std::invalid_argument(fmt::format("a camera of {} x {} pixels", c.width, c.height));
  }
  if (!(c.fx > 0.0 && c.fy > 0.0) || !std::isfinite(c.fx) || !std::isfinite(c.fy)) {
    throw std::invalid_argument(fmt::format("focal lengths of {} and {} px", c.fx, c.fy));
  }
  if (!(c.cx >= 0.0 && c.cx < c.width && c.cy >= 0.0 && c.cy < c.height)) {
    throw std::invalid_argument(
        fmt::format("the principal point ({:.1f}, {:.1f}) is not in the picture of {} x {} pixels",
                    c.cx, c.cy, c.width, c.height));
  }
  const double baseline = (calibration.X_WR.translation() - calibration.X_WL.translation()).norm();
  if (!(baseline >= kMinBaseline_m)) {
    throw std::invalid_argument(
        fmt::format("left and right stand in one place ({:.4f} mm apart): nothing to triangulate",
                    baseline * base::kMmPerM));
  }
}

StereoCalibration ReadStereoCalibration(const std::filesystem::path& file) {
  auto map = base::YamlMap::FromFile(file);
  StereoCalibration calibration;
  for (const char* key : {"camera", "left", "right"}) map.Require(key);
  auto camera = map.Child("camera", "pinhole camera with the distortion of equations 5.10 to 5.12");
  internal::ReadCamera(camera, calibration.camera);
  auto left = map.Child("left", "where it took the left picture");
  calibration.X_WL = sensing::ReadPose(left, kFrame);
  auto right = map.Child("right", "where it took the right picture");
  calibration.X_WR = sensing::ReadPose(right, kFrame);
  map.Read("reprojection_px", calibration.reprojection_px, 0.0, 1e3,
           "residual of the camera's calibration; 0: not known");
  map.ReadScaled("registration_mm", calibration.registration_m, base::kMm, 0.0, 1e3,
                 "residual of the registration to the arm; 0: not known");
  map.Finish();
  try {
    CheckCalibration(calibration);
  } catch (const std::invalid_argument& error) {
    throw base::InputError(fmt::format("{}: {}", file.string(), error.what()));
  }
  return calibration;
}

void WriteStereoCalibration(const StereoCalibration& calibration,
                            const std::filesystem::path& file) {
  std::string text =
      "# One camera that takes two pictures: its model, and where it stands at each in the arm's "
      "frame.\n# Axes of the camera: x right, y down, z forward.\n";
  text += internal::CameraText("camera", calibration.camera) +
          sensing::PoseText("left", calibration.X_WL) +
          sensing::PoseText("right", calibration.X_WR);
  text += fmt::format("reprojection_px: {:.17g}\nregistration_mm: {:.17g}\n",
                      calibration.reprojection_px, calibration.registration_m * base::kMmPerM);
  base::WriteFile(file, text);
}

}  // namespace rangegrasp::stereo
