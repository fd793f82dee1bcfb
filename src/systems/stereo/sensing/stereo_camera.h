#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "base/frames.h"
#include "base/image/image.h"
#include "base/rng.h"
#include "base/units.h"
#include "sim/render.h"
#include "sim/world.h"
#include "stereo/camera.h"

namespace rangegrasp::sensing {

/// One camera on the scanner's pan/tilt unit that takes two pictures at two pan angles (section
/// 5.3, figure 5.18). S is the scanner head's frame; the camera turns about its y axis. The head's
/// pitch (-37 deg) is that of the scene's site. At a pan of 0 the camera is `ahead_m` in front of
/// the axis along S's z and looks along z, so a turn moves it sideways by the baseline b = ahead *
/// 2 sin(turn / 2). The dissertation states neither its position nor its lens; the defaults are
/// those of docs/results.md.
///
/// These are the ground truth of the simulation. Users of the pictures only know what a calibration
/// found of them. The keys in ReadStereoCamera describe each option.
struct StereoCameraOptions {
  int width = 1600;
  int height = 1200;
  double focal_px = 2000.0;
  // A real lens is never exactly as designed: its axis misses the sensor's middle, it bends
  // straight lines (5.10 to 5.12: barrel distortion, less than 1 % in the corners, slightly
  // decentred), and its mount is slightly off.
  double center_right_px = 7.3;
  double center_down_px = -5.8;
  double k1 = -0.11;
  double k2 = 0.14;
  double p1 = 0.0006;
  double p2 = -0.0004;
  double ahead_m = 0.30;
  double mount_right_m = 0.0021;  ///< in addition to `ahead_m`
  double mount_down_m = -0.0014;
  double mount_roll_rad = base::Deg(0.6);
  double mount_pitch_rad = base::Deg(-0.4);
  double mount_yaw_rad = base::Deg(0.5);

  double left_pan_rad = base::Deg(-4.0);
  double right_pan_rad = base::Deg(0.0);
  /// About the nominal angle. The unit's data sheet states 0.02 deg for both directions; it is
  /// better if an angle is always approached from one side. b, and thus depth, depends on it.
  double pan_sigma_rad = base::Deg(0.002);

  /// Print that the models' labels omit. Without it, most of a package has one colour, which is
  /// harder than the objects in a kitchen.
  bool fine_print = true;
  int shadow_px = 2048;  ///< the shadow map spans the room
  double exposure_sigma = 0.02;
  double noise_levels = 3.0;  ///< 2.0 in the grey value
};

/// Reads models/sensors/stereo_camera.yaml; absent keys keep their defaults.
/// @throws base::InputError like ReadLineScanner.
StereoCameraOptions ReadStereoCamera(const std::filesystem::path& file);

/// Maps each pixel of a photograph to its place in a picture drawn without distortion (equations
/// 5.10 to 5.12). The drawn picture has the lens's focal length and contains all that the lens
/// sees.
class LensMap {
 public:
  /// @param camera  square pixels: fx is fy.
  /// @throws std::invalid_argument if its distortion cannot be undone within the picture.
  explicit LensMap(const stereo::Camera& camera);

  int drawn_width() const { return drawn_width_; }
  int drawn_height() const { return drawn_height_; }
  /// Principal point of the drawn picture [px].
  const Eigen::Vector2d& drawn_center_px() const { return drawn_center_; }

  /// A row of the photograph: 3 values per pixel [1 / kOne of a grey level], each interpolated
  /// between the four nearest drawn pixels.
  static constexpr int kOne = 1 << 6;
  void SampleRow(const image::Image& drawn, int row, std::vector<std::int32_t>& out) const;

 private:
  struct Place {
    std::uint32_t pixel;        // the upper left of the four, as an index into rgb
    std::uint16_t right, down;  // weights of the others, in 1 / kShare
  };
  int width_;
  int drawn_width_ = 0;
  int drawn_height_ = 0;
  Eigen::Vector2d drawn_center_;
  std::vector<Place> places_;
};

/// Smooths along rows and columns by three weights with the variance sigma_px^2 (<= 1).
void Blur(image::Image& picture, double sigma_px);

/// Fast normal noise: 12 random bits select one of the quantiles of the normal distribution.
class PixelNoise {
 public:
  /// @param sigma  standard deviation, in units of the values
  explicit PixelNoise(double sigma);
  void AddTo(std::vector<std::int32_t>& values, base::Rng& rng) const;

 private:
  std::vector<std::int32_t> quantiles_;
};

/// Ground truth that only the scorer may read: the true lens and its pose at each picture.
struct StereoTruth {
  stereo::Camera lens;
  base::Pose X_WL, X_WR;
};

struct StereoShot {
  stereo::PicturePair photos;  ///< what the robot gets
  StereoTruth truth;
};

/// Ground truth of a pixel of a photograph.
struct PixelTruth {
  std::uint32_t label = 0;  ///< of sim::VisualMesh; 0 if its ray hits nothing
  double depth_m = 0.0;     ///< along the camera's axis; NaN if its ray hits nothing
};

/// The lens of the options, as an error-free calibration would find it.
stereo::Camera LensOf(const StereoCameraOptions& options);
/// Pose of the camera at a pan angle in the frame S of the scanner's head, including mounting
/// errors.
base::Pose CameraInHead(const StereoCameraOptions& options, double pan_rad);

/// Takes pictures of a simulated world: drawn by the engine's renderer, distorted by the lens,
/// darkened towards the corners, with sensor noise. Can be made once and used in forked processes.
class StereoCamera {
 public:
  /// @throws std::invalid_argument if the distortion folds the picture.
  explicit StereoCamera(const StereoCameraOptions& options);

  /// A renderer for many pictures of one world.
  std::unique_ptr<sim::Renderer> RendererOf(const sim::World& world) const;
  /// @param X_WS  the scanner head's pose.
  /// @param rng   one draw of it; the noise depends on nothing else.
  /// @throws base::RunError if no offscreen picture can be made.
  StereoShot Photograph(const sim::World& world, const base::Pose& X_WS, base::Rng& rng) const;
  StereoShot Photograph(const sim::World& world, sim::Renderer& renderer, const base::Pose& X_WS,
                        base::Rng& rng) const;
  /// One picture from any camera pose X_WC.
  image::Image Picture(const sim::World& world, sim::Renderer& renderer, const base::Pose& X_WC,
                       std::uint64_t seed) const;

 private:
  StereoCameraOptions options_;
  stereo::Camera lens_;
  LensMap map_;
  PixelNoise noise_;
};

/// Labels and depths of pixels of a photograph, by tracing their rays. For the scorer.
/// @param lens, X_WC  those of the photograph
/// @param pixels  columns and rows, which may lie between pixels; NaN hits nothing
/// @throws std::invalid_argument naming the mesh whose vertex is not finite.
std::vector<PixelTruth> TruthOfPixels(std::span<const sim::VisualMesh> meshes,
                                      const stereo::Camera& lens, const base::Pose& X_WC,
                                      std::span<const Eigen::Vector2d> pixels);

}  // namespace rangegrasp::sensing
