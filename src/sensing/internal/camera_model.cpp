#include "sensing/internal/camera_model.h"

#include <Eigen/Geometry>
#include <cmath>

namespace rangegrasp::sensing::internal {
namespace {

// Below this the camera's ray and the fan are parallel: they meet beyond 300 km.
constexpr double kParallel = 1e-6;

}  // namespace

double PanAngle(const LineScannerOptions& options, int profile) {
  if (options.profiles < 2) return 0.0;
  return options.pan_range_rad * (static_cast<double>(profile) / (options.profiles - 1) - 0.5);
}

Eigen::Matrix3d PanRotation(double pan_rad) {
  return Eigen::AngleAxisd(pan_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
}

double Slope(const LineScannerOptions& options, double sample) {
  if (options.samples < 2) return 0.0;
  return std::tan(0.5 * options.fan_rad) * (2.0 * sample / (options.samples - 1) - 1.0);
}

CameraModel::CameraModel(const LineScannerOptions& options)
    : baseline_m_(options.baseline_m),
      sin_(std::sin(std::atan2(options.baseline_m, options.focus_distance_m))),
      cos_(std::cos(std::atan2(options.baseline_m, options.focus_distance_m))),
      scale_px_(options.focal_length_m / options.pixel_pitch_m),
      half_px_(0.5 * options.sensor_pixels),
      half_slope_(std::tan(0.5 * options.fan_rad)),
      line_width_m_(options.line_width_m),
      blur_px_(options.blur_px) {}

bool CameraModel::InView(const Eigen::Vector3d& p_P) const {
  const double axial_m = AxialDistance(p_P.x(), p_P.z());
  return axial_m > 0.0 && std::abs(p_P.y()) <= half_slope_ * axial_m &&
         OnSensor(Column(p_P.x(), p_P.z()));
}

std::optional<double> CameraModel::Depth(double column_px) const {
  const double q = column_px / scale_px_;
  const double numerator = baseline_m_ * (cos_ + q * sin_);
  const double denominator = sin_ - q * cos_;
  if (numerator <= 0.0 || denominator <= kParallel) return std::nullopt;
  return numerator / denominator;
}

double CameraModel::DepthPerPixel(double depth_m) const {
  const double axial_m = AxialDistance(0.0, depth_m);
  return axial_m * axial_m / (scale_px_ * baseline_m_);
}

double CameraModel::SpotWidth(double axial_distance_m) const {
  return std::hypot(line_width_m_ * scale_px_ / axial_distance_m, blur_px_);
}

double SpeckleSigma(const LineScannerOptions& options) {
  return options.speckle_sigma_m / CameraModel(options).DepthPerPixel(1.0);
}

double CentroidSigma(const LineScannerOptions& options) {
  const double speckle_px = SpeckleSigma(options);
  const double variance_px2 = options.centroid_sigma_px * options.centroid_sigma_px +
                              speckle_px * speckle_px +
                              options.quantisation_px * options.quantisation_px / 12.0;
  return std::sqrt(variance_px2);
}

}  // namespace rangegrasp::sensing::internal
