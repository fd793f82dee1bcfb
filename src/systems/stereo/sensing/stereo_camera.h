#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/frames.h"
#include "base/image/image.h"
#include "base/rng.h"
#include "sim/render.h"
#include "sim/visual_mesh.h"
#include "sim/world.h"
#include "stereo/camera.h"
#include "stereo/sensing/stereo_camera_options.h"

namespace rangegrasp::sensing {

/// The two pictures that the camera took, turned to the left and to the right angle.
struct StereoPhotos {
  image::Image left;
  image::Image right;
};

/// What only the scorer may read: the lens as it is and where it stood at each picture.
struct StereoTruth {
  stereo::Camera lens;
  base::Pose X_WL;
  base::Pose X_WR;
};

struct StereoShot {
  StereoPhotos photos;  ///< what the robot gets
  StereoTruth truth;
};

/// What a pixel of a photograph shows.
struct PixelTruth {
  std::uint32_t label = 0;  ///< of sim::VisualMesh; 0 where nothing is met
  double depth_m = 0.0;     ///< along the camera's axis; NaN where nothing is met
};

/// The lens of the options, as a calibration would find it if it made no error.
stereo::Camera LensOf(const StereoCameraOptions& options);
/// Where the camera stands at a pan angle, in the frame S of the scanner's head, its errors of
/// mounting with it.
base::Pose CameraInHead(const StereoCameraOptions& options, double pan_rad);

/// What the numbers of a camera say about the depth of a pair at one distance, before anything is
/// matched: the noise of a picture's grey values and of the pan unit, both as disparities.
struct StereoNoise {
  double baseline_m = 0.0;         ///< 2 ahead sin(turn / 2)
  double disparity_px = 0.0;       ///< f b / z
  double depth_per_pixel_m = 0.0;  ///< z^2 / (f b)
  /// The least that windows of n x n pixels leave, whose grey values change by g levels a pixel
  /// (rms): sqrt(2) sigma / (g n), the Cramer-Rao bound of a shift (both pictures have sigma).
  double matching_px = 0.0;
  double pan_px = 0.0;  ///< sqrt(2) f sigma_pan: one draw a pair, which moves all of it
};

/// @param depth_m    z, > 0.
/// @param slope      g, > 0, in levels a pixel.
/// @param window_px  n, > 0.
StereoNoise ExpectedStereoNoise(const StereoCameraOptions& options, double depth_m, double slope,
                                int window_px);

/// Takes pictures of a simulated world: drawn by the engine's renderer with its lights, shadows and
/// textures, bent by the lens, darkened towards the corners, with noise of the sensor. Owns the
/// lens's map alone: it may be made once and used in forked processes.
class StereoCamera {
 public:
  /// @throws std::invalid_argument as CheckOptions, or if the distortion folds the picture.
  explicit StereoCamera(const StereoCameraOptions& options);
  ~StereoCamera();
  StereoCamera(const StereoCamera&) = delete;
  StereoCamera& operator=(const StereoCamera&) = delete;

  /// A renderer for the pictures of a world, for who takes many of it.
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
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Labels and depths of pixels of a photograph, by tracing the rays that they see. For the scorer.
/// @param lens    as it is.
/// @param X_WC    where it stood at that photograph.
/// @param pixels  columns and rows, which may lie between pixels; a NaN meets nothing.
/// @throws std::invalid_argument naming the mesh whose vertex is not finite.
std::vector<PixelTruth> TruthOfPixels(std::span<const sim::VisualMesh> meshes,
                                      const stereo::Camera& lens, const base::Pose& X_WC,
                                      std::span<const Eigen::Vector2d> pixels);

}  // namespace rangegrasp::sensing
