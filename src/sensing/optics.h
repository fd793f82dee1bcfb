#pragma once

#include <Eigen/Core>
#include <span>

#include "geometry/ray_caster.h"
#include "sensing/line_scanner_options.h"
#include "sim/visual_mesh.h"

namespace rangegrasp::sensing {

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
  double baseline_m_, sin_, cos_;
  double scale_px_;  ///< f / p
  double half_px_, half_slope_, line_width_m_, blur_px_;
};

/// Standard deviation [px] of the centroid by speckle: constant in the image, as a speckle's size
/// there is, hence growing with the square of the distance in depth (Dorsch et al. 1994).
double SpeckleSigma(const LineScannerOptions& options);

/// Standard deviation [px] of the centroid by all that disturbs it: white noise, speckle and
/// quantisation.
double CentroidSigma(const LineScannerOptions& options);

using geometry::Hit;
using geometry::Ray;

/// Rays among what a sensor may see; Hit::mesh is the position in `meshes`.
class RayCaster : public geometry::RayCaster {
 public:
  /// @throws std::invalid_argument as geometry::RayCaster
  explicit RayCaster(std::span<const sim::VisualMesh> meshes)
      : geometry::RayCaster(SurfacesOf(meshes)) {}

 private:
  static std::vector<const geometry::TriangleMesh*> SurfacesOf(
      std::span<const sim::VisualMesh> meshes) {
    std::vector<const geometry::TriangleMesh*> surfaces;
    for (const sim::VisualMesh& mesh : meshes) surfaces.push_back(&mesh.mesh_W);
    return surfaces;
  }
};

/// Where light meets a surface; all angles [rad].
struct Encounter {
  double incidence_rad = 0.0;       ///< between the laser's ray and the normal
  double mirror_offset_rad = 3.14;  ///< between the mirrored ray and the direction to the camera
};

/// Probabilities of losing a sample that the camera could see.
/// 0 up to dropout_begin, linear to 1 at dropout_end.
double IncidenceLoss(const RangeSensorOptions& options, double incidence_rad);
/// 0 from an albedo of 0.10 up, 0.5 at 0.05, 0.9 at 0, linear between.
double AlbedoLoss(double albedo);
/// The gloss itself within saturation_angle of the mirror direction, else 0: a share of the patches
/// of a surface is smooth enough to blind the camera.
double GlossLoss(const RangeSensorOptions& options, double gloss, double mirror_offset_rad);
/// Loss of a single sample: for darkness and, independently, for clarity: that share of the light
/// goes through or is mirrored away inside.
double SampleLoss(double albedo, double clarity);
/// Loss of a whole patch of a surface: for grazing light and, independently, gloss.
double PatchLoss(const RangeSensorOptions& options, double gloss, const Encounter& encounter);

/// Diffuse albedo at 635 nm of a printed color with this red channel (sRGB): linear from the 4 %
/// that the darkest inks and coatings send back to the 85 % of white board. Estimates.
double PrintAlbedo(std::uint8_t red);

/// Albedo at 635 nm where a ray met a mesh: of the print, where there is one.
double AlbedoAt(const sim::VisualMesh& mesh, const Hit& hit);

/// What the room's light, half of it from above, shows where a ray met a mesh: each channel 0..1.
/// What is of no known color is grey.
Eigen::Vector3d RoomLight(const sim::VisualMesh& mesh, const Hit& hit);

/// Parts of surfaces that are lost as a whole: one draw for all that lies in a cell of a grid.
class Patches {
 public:
  /// @param size_m  of a cell; 0: each place is its own
  Patches(double size_m, std::uint64_t seed);
  /// Whether a point's patch is lost, which it is with the probability `loss`.
  bool IsLost(const Eigen::Vector3f& point_W, double loss) const;

 private:
  double size_m_;
  std::uint64_t seed_;
  Eigen::Vector3d shift_;
};

/// Light of a part of the line as the camera sees it.
struct Glint {
  double column_px = 0.0;
  double brightness = 0.0;  ///< >= 0
  std::size_t source = 0;   ///< what the caller wants to know it by
};

/// A peak of the line's image.
struct Blob {
  double column_px = 0.0;  ///< centroid
  double low_px = 0.0;     ///< extent: the columns of its outermost glints
  double high_px = 0.0;
  double brightness = 0.0;  ///< sum
  std::size_t source = 0;   ///< of its brightest glint
};

/// Splits glints where neighbors in the image lie further apart than `width_px` and returns the
/// brightest group's centroid; of equals the one with the smaller column. Sorts `glints`.
/// @return brightness 0 if there is no light.
Blob BrightestBlob(std::span<Glint> glints, double width_px);

}  // namespace rangegrasp::sensing
