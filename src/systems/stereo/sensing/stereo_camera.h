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
#include "sim/visual_mesh.h"
#include "sim/world.h"
#include "stereo/camera.h"

namespace rangegrasp::sensing {

/// One camera on the scanner's pan/tilt unit that takes two pictures, turned by two angles (section
/// 5.3, figure 5.18). S is the scanner head's frame, whose y axis it turns about; the head's pitch
/// (-37 deg) is that of the scene's site. Turned by 0 the camera stands `ahead_m` before the axis
/// along S's z and looks along it, so that a turn moves it sideways by the baseline
/// b = ahead * 2 sin(turn / 2). The dissertation names neither its place nor its lens; the defaults
/// are those of docs/results.md.
///
/// These are the truth of what is simulated. Who looks at the pictures knows of them what a
/// calibration found. What each is stands with its key (ReadStereoCamera).
struct StereoCameraOptions {
  int width = 1600;
  int height = 1200;
  double focal_px = 2000.0;
  // A lens is never built as it is drawn: its axis misses the sensor's middle, it bends what is
  // straight (5.10 to 5.12: barrel, less than 1 % in the corners, and a little decentred), and its
  // mount is a little off.
  double center_right_px = 7.3;
  double center_down_px = -5.8;
  double k1 = -0.11;
  double k2 = 0.14;
  double p1 = 0.0006;
  double p2 = -0.0004;
  double ahead_m = 0.30;
  double mount_right_m = 0.0021;  ///< further than `ahead_m` says
  double mount_down_m = -0.0014;
  double mount_roll_rad = base::Deg(0.6);
  double mount_pitch_rad = base::Deg(-0.4);
  double mount_yaw_rad = base::Deg(0.5);

  double left_pan_rad = base::Deg(-4.0);
  double right_pan_rad = base::Deg(0.0);
  /// About the nominal angle. The unit's data sheet says 0.02 deg both ways; always come to from
  /// one side, it is better. b, and with it depth, depends on it.
  double pan_sigma_rad = base::Deg(0.002);

  int edge_samples = 0;  ///< lens_blur_px smooths edges, too
  /// Which the models' labels leave out. Without it most of a package is of one colour, which is
  /// harder than what a kitchen holds.
  bool fine_print = true;
  int shadow_px = 2048;  ///< spans the room
  double lens_blur_px = 0.6;
  double vignetting = 0.25;
  double exposure_sigma = 0.02;
  double noise_levels = 3.0;  ///< 2.0 in their grey
};

/// Reads models/sensors/stereo_camera.yaml; what is not given keeps its default.
/// @throws base::InputError as ReadLineScanner.
StereoCameraOptions ReadStereoCamera(const std::filesystem::path& file);

/// @throws std::invalid_argument naming the key (in the units of a sensor file) that is out of
/// range, its value and its range.
void CheckOptions(const StereoCameraOptions& options);

/// For each pixel of a photograph the place that it sees in a picture drawn without distortion
/// (equations 5.10 to 5.12). The drawn picture has the lens's focal length and is large enough to
/// hold all that the lens sees.
class LensMap {
 public:
  /// @param camera  square pixels: fx is fy.
  /// @throws std::invalid_argument if its distortion cannot be undone within the picture.
  explicit LensMap(const stereo::Camera& camera);

  int drawn_width() const { return drawn_width_; }
  int drawn_height() const { return drawn_height_; }
  /// Principal point of the drawn picture [px].
  const Eigen::Vector2d& drawn_center_px() const { return drawn_center_; }

  /// A row of the photograph: 3 values a pixel [1 / kOne of a grey level], each interpolated
  /// between the four nearest drawn pixels.
  static constexpr int kOne = 1 << 6;
  void SampleRow(const image::Image& drawn, int row, std::vector<std::int32_t>& out) const;

 private:
  struct Place {
    std::uint32_t pixel;        // the upper left of the four, as an index into rgb
    std::uint16_t right, down;  // shares of the others, of kShare
  };
  int width_;
  int drawn_width_ = 0;
  int drawn_height_ = 0;
  Eigen::Vector2d drawn_center_;
  std::vector<Place> places_;
};

/// Smooths along rows and columns by three weights with the variance sigma_px^2 (<= 1).
void Blur(image::Image& picture, double sigma_px);

/// Normal numbers, fast: quantiles of the normal distribution, of which 12 random bits pick one.
class PixelNoise {
 public:
  /// @param sigma  standard deviation, in units of the values
  explicit PixelNoise(double sigma);
  void AddTo(std::vector<std::int32_t>& values, base::Rng& rng) const;

 private:
  std::vector<std::int32_t> quantiles_;
};

/// What only the scorer may read: the lens as it is and where it stood at each picture.
struct StereoTruth {
  stereo::Camera lens;
  base::Pose X_WL, X_WR;
};

struct StereoShot {
  stereo::PicturePair photos;  ///< what the robot gets
  StereoTruth truth;
};

/// What a pixel of a photograph shows.
struct PixelTruth {
  std::uint32_t label = 0;  ///< of sim::VisualMesh; 0 where nothing is met
  double depth_m = 0.0;     ///< along the camera's axis; NaN where nothing is met
};

/// The lens of the options, as a calibration would find it if it made no error.
stereo::Camera LensOf(const StereoCameraOptions& options);
/// Where the camera stands at a pan angle in the frame S of the scanner's head, by how it is
/// mounted.
base::Pose CameraInHead(const StereoCameraOptions& options, double pan_rad);

/// Takes pictures of a simulated world: drawn by the engine's renderer, bent by the lens, darkened
/// towards the corners, with noise of the sensor. May be made once and used in forked processes.
class StereoCamera {
 public:
  /// @throws std::invalid_argument as CheckOptions, or if the distortion folds the picture.
  explicit StereoCamera(const StereoCameraOptions& options);

  /// A renderer for many pictures of one world.
  std::unique_ptr<sim::Renderer> RendererOf(const sim::World& world) const;
  /// @param X_WS  the scanner head's pose.
  /// @param rng   one draw of it; depends on nothing else.
  /// @throws base::RunError if no offscreen picture can be made.
  StereoShot Photograph(const sim::World& world, const base::Pose& X_WS, base::Rng& rng) const;
  StereoShot Photograph(const sim::World& world, sim::Renderer& renderer, const base::Pose& X_WS,
                        base::Rng& rng) const;
  /// One picture from anywhere. @param X_WC  where the camera stands.
  image::Image Picture(const sim::World& world, sim::Renderer& renderer, const base::Pose& X_WC,
                       base::Rng& rng) const;

 private:
  image::Image Photo(const sim::World& world, sim::Renderer& renderer, const base::Pose& X_WC,
                     std::uint64_t seed) const;

  StereoCameraOptions options_;
  stereo::Camera lens_;
  LensMap map_;
  PixelNoise noise_;
};

/// Labels and depths of pixels of a photograph, by tracing the rays that they see. For the scorer.
/// @param lens, X_WC  as they were at that photograph
/// @param pixels  columns and rows, which may lie between pixels; a NaN meets nothing
/// @throws std::invalid_argument naming the mesh whose vertex is not finite.
std::vector<PixelTruth> TruthOfPixels(std::span<const sim::VisualMesh> meshes,
                                      const stereo::Camera& lens, const base::Pose& X_WC,
                                      std::span<const Eigen::Vector2d> pixels);

}  // namespace rangegrasp::sensing
