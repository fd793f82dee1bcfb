#pragma once

#include <Eigen/Core>
#include <span>

#include "base/frames.h"
#include "geometry/ray_caster.h"
#include "sensing/range_sensor.h"
#include "sim/world.h"

namespace rangegrasp::sensing {

/// Angle of the pan axis at a profile [rad]: evenly spaced, -range/2 first.
double PanAngle(const LineScannerOptions& options, int profile);

/// Rotation R_SP of a profile's frame: about S's y axis, so that z_P = (sin, 0, cos) in S.
Eigen::Matrix3d PanRotation(double pan_rad);

/// y_P / z_P of a sample's ray: evenly spaced, -tan(fan/2) first. `sample` may be fractional.
double Slope(const LineScannerOptions& options, double sample);

/// The camera of one profile, in the frame P. Its axis is rotated by alpha = atan(b / F). A point
/// (x, y, z) has the camera coordinates
///   Xc = (x - b) cos(alpha) + z sin(alpha),  Zc = -(x - b) sin(alpha) + z cos(alpha),
/// and its image across the line is u = (f / p) Xc / Zc pixels from the center.
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
  /// Depth of the point of the fan (x = 0) seen at u: with q = u p / f,
  ///   z = b (cos + q sin) / (sin - q cos); nullopt if the rays do not meet in front of the head.
  std::optional<double> Depth(double column_px) const;
  /// dz/du = Zc^2 p / (f b) [m/px] at a depth in the fan.
  double DepthPerPixel(double depth_m) const;
  /// 1/e^2 width [px] of the line's image at an axial distance: line and blur, added in quadrature.
  double SpotWidth(double axial_distance_m) const;

 private:
  double baseline_m_, sin_, cos_;
  double scale_px_;  ///< f / p
  double half_px_, half_slope_, line_width_m_, blur_px_;
};

/// Standard deviation [px] of the centroid due to speckle. It is constant in the image, like the
/// size of speckles, so the depth error grows with the distance squared (Dorsch et al. 1994).
double SpeckleSigma(const LineScannerOptions& options);

/// Total standard deviation [px] of the centroid: white noise, speckle and quantization.
double CentroidSigma(const LineScannerOptions& options);

using geometry::Hit;
using geometry::Ray;
using geometry::RayCaster;

/// Casts rays at the visual meshes; Hit::mesh is the position in `meshes`.
/// @throws std::invalid_argument like RayCaster
RayCaster CasterOf(std::span<const sim::VisualMesh> meshes);

/// The pose of a sensor's head that the robot knows: the true one with a calibration error.
/// @param seed  of the scan
base::Pose KnownPose(const base::Pose& X_WS, const RangeSensorOptions& options, std::uint64_t seed);

/// Probability of losing a sample that the camera could see, by the angle of incidence: 0 up to
/// dropout_begin, linear to 1 at dropout_end.
double IncidenceLoss(const RangeSensorOptions& options, double incidence_rad);
/// The same by albedo: 0 for 0.10 or more, 0.5 at 0.05, 0.9 at 0, linear in between.
double AlbedoLoss(double albedo);
/// The same by gloss: the gloss itself within saturation_angle of the mirror direction, otherwise
/// 0. This share of the patches of a surface is smooth enough to blind the camera.
double GlossLoss(const RangeSensorOptions& options, double gloss, double mirror_offset_rad);
/// Probability of losing a single sample, by darkness and, independently, by clarity: this share of
/// the light passes through or is reflected away inside.
double SampleLoss(double albedo, double clarity);
/// Probability of losing a whole patch of a surface, by grazing light and, independently, by gloss.
/// @param incidence_rad      angle between the laser's ray and the normal
/// @param mirror_offset_rad  angle between the mirrored ray and the direction to the camera
double PatchLoss(const RangeSensorOptions& options, double gloss, double incidence_rad,
                 double mirror_offset_rad);

/// Diffuse albedo at 635 nm of a printed color with this red channel (sRGB): linear from 4 % for
/// the darkest inks and coatings to 85 % for white board. Estimates.
double PrintAlbedo(std::uint8_t red);

/// Albedo at 635 nm at a hit on a mesh: of the print, if there is one.
double AlbedoAt(const sim::VisualMesh& mesh, const Hit& hit);

/// Room light that a mesh reflects at a hit, each channel 0..1. Half of the light comes from above.
/// Surfaces without a known color are gray.
Eigen::Vector3d RoomLight(const sim::VisualMesh& mesh, const Hit& hit);

/// Parts of surfaces that are lost as a whole: all points in a cell of a grid share one draw.
class Patches {
 public:
  /// @param size_m  size of a cell; 0: each point is drawn separately
  Patches(double size_m, std::uint64_t seed);
  /// Whether a point's patch is lost. The probability is `loss`.
  bool IsLost(const Eigen::Vector3f& point_W, double loss) const;

 private:
  double size_m_;
  std::uint64_t seed_;
  Eigen::Vector3d shift_;
};

/// Light from a part of the line in the camera's image.
struct Glint {
  double column_px = 0.0;
  double brightness = 0.0;  ///< >= 0
  std::size_t source = 0;   ///< the caller's identifier
};

/// A peak of the line's image.
struct Blob {
  double column_px = 0.0;  ///< centroid
  double low_px = 0.0;     ///< extent: the columns of its outermost glints
  double high_px = 0.0;
  double brightness = 0.0;  ///< sum
  std::size_t source = 0;   ///< of its brightest glint
};

/// Splits glints into groups where neighbors in the image are further apart than `width_px`, and
/// returns the brightest (0: no light); of equal ones, of the smaller column. Sorts `glints`.
Blob BrightestBlob(std::span<Glint> glints, double width_px);

}  // namespace rangegrasp::sensing
