#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/frames.h"
#include "core/rng.h"
#include "geometry/range_image.h"
#include "geometry/visual_mesh.h"

namespace rangegrasp::sensing {

/// A laser plane and a camera on one head that pans. Defaults: hardware facts (SICK IVP MAPP2500
/// class, Lasiris 635 nm). The head's frame S (x right, y down, z forward) has its origin in the
/// laser's exit point; the pan axis is the head's vertical axis through it. The fan lies in the S
/// y-z plane; the camera stands at a baseline along x and is turned inwards.
struct LineScannerOptions {
  int samples = 512;  ///< a profile
  int profiles = 150;
  double fan_rad = 0.611;  ///< 35 deg, opening of the laser fan (and of the camera along the line)
  double pan_range_rad =
      0.60;  ///< from the first to the last profile, symmetric round straight ahead
  double baseline_m = 0.30;
  double focal_length_m = 0.016;
  double pixel_pitch_m = 9.5e-6;
  int sensor_pixels = 512;         ///< across the line: limits the depth range that is seen
  double focus_distance_m = 1.0;   ///< the camera's axis meets the laser plane here
  double line_width_m = 0.001;     ///< 1/e^2 width of the line at focus_distance_m
  double centroid_sigma_px = 0.1;  ///< white noise of the line's centroid
  double speckle_sigma_m =
      0.0002;  ///< range noise by speckle at 1 m, correlated over correlation_samples
  double correlation_samples = 2.0;
  double quantisation_px = 0.0625;          ///< 1/16 px
  double pan_jitter_rad = 0.00034907;       ///< 0.02 deg, one value a profile
  double dropout_begin_rad = 1.0471976;     ///< incidence from which samples drop out (60 deg)
  double dropout_end_rad = 1.3962634;       ///< incidence at which all are lost (80 deg)
  double saturation_angle_rad = 0.0872665;  ///< gloss blinds within this of the mirror direction
};

/// Reads models/sensors/*.yaml; keys are the option names in human units (documented in the file),
/// unknown keys are errors.
/// @throws core::InputError naming file, line and key.
LineScannerOptions ReadLineScanner(const std::filesystem::path& file);

/// Why a sample of the range image is what it is.
enum class SampleState : std::uint8_t {
  kMeasured,
  kLaserShadow,
  kCameraShadow,
  kDropout,
  kOutOfView
};

/// What only the scorer may read; the same layout as the image.
struct ScanTruth {
  std::vector<SampleState> state;
  std::vector<std::uint32_t> label;  ///< of the surface hit by the laser; 0 where nothing
  std::vector<double>
      true_range_m;  ///< from the laser's origin to the true surface; NaN where nothing
};

struct Scan {
  geometry::RangeImage image;  ///< in W by the nominal calibration X_WS (what the robot knows)
  ScanTruth truth;
};

/// One sweep over the meshes (design: a ray from the laser to the first surface; a second to the
/// camera decides whether it is seen; the line's image, its centroid bent at depth edges by the
/// spot's width, is quantised and disturbed; the point is triangulated). The meaning of "laser
/// shadow": the sample's ray hits something, but a surface behind is in the laser's shadow: a gap
/// in the cloud that a depth step along the profile leaves shows no sample; so kLaserShadow marks
/// samples whose neighbours' step hides surface from the laser (documented in the source),
/// kCameraShadow those lit but hidden from the camera.
Scan ScanScene(std::span<const geometry::VisualMesh> meshes, const core::Pose& X_WS,
               const LineScannerOptions& options, core::Rng& rng);

}  // namespace rangegrasp::sensing
