#pragma once

#include <Eigen/Core>
#include <optional>

#include "sensing/line_scanner_options.h"

namespace rangegrasp::sensing::internal {

/// Angle of the pan axis at a profile [rad]: evenly spaced, -range/2 first.
double PanAngle(const LineScannerOptions& options, int profile);

/// Rotation R_SP of a profile's frame: about S's y axis, so that z_P = (sin, 0, cos) in S.
Eigen::Matrix3d PanRotation(double pan_rad);

/// y_P / z_P of a sample's ray: evenly spaced, -tan(fan/2) first. May be asked for fractions.
double Slope(const LineScannerOptions& options, double sample);

/// The camera of one profile, in the frame P. With the camera's axis turned by alpha = atan(b / F)
/// a point (x, y, z) has
///   Xc = (x - b) cos(alpha) + z sin(alpha),  Zc = -(x - b) sin(alpha) + z cos(alpha)
/// and its image across the line lies u = (f / p) Xc / Zc pixels from the middle.
class CameraModel {
 public:
  explicit CameraModel(const LineScannerOptions& options);

  Eigen::Vector3d Center() const { return {baseline_m_, 0.0, 0.0}; }
  /// Zc [m].
  double AxialDistance(double x_m, double z_m) const {
    return z_m * cos_ - (x_m - baseline_m_) * sin_;
  }
  /// u [px] of a point in front of the camera.
  double Column(double x_m, double z_m) const {
    return scale_px_ * ((x_m - baseline_m_) * cos_ + z_m * sin_) / AxialDistance(x_m, z_m);
  }
  /// Whether a point falls on the sensor's window.
  bool InView(const Eigen::Vector3d& p_P) const;
  bool OnSensor(double column_px) const { return column_px >= -half_px_ && column_px <= half_px_; }
  /// Depth of the fan's point (x = 0) seen at u: with q = u p / f,
  ///   z = b (cos + q sin) / (sin - q cos); nullopt where the two rays do not meet in front.
  std::optional<double> Depth(double column_px) const;
  /// dz/du = Zc^2 p / (f b) [m/px] at a depth in the fan.
  double DepthPerPixel(double depth_m) const;
  /// 1/e^2 width [px] of the line's image at an axial distance: line and blur in quadrature.
  double SpotWidth(double axial_distance_m) const;

 private:
  double baseline_m_;
  double sin_;
  double cos_;
  double scale_px_;  ///< f / p
  double half_px_;
  double half_slope_;
  double line_width_m_;
  double blur_px_;
};

/// Standard deviation [px] of the centroid by speckle: constant in the image, as a speckle's size
/// there is, hence growing with the square of the distance in depth (Dorsch et al. 1994).
double SpeckleSigma(const LineScannerOptions& options);

/// Standard deviation [px] of the centroid by all that disturbs it: white noise, speckle and
/// quantisation.
double CentroidSigma(const LineScannerOptions& options);

}  // namespace rangegrasp::sensing::internal
