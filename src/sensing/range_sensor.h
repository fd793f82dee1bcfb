#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "base/frames.h"
#include "base/rng.h"
#include "base/units.h"
#include "geometry/observation.h"
#include "sim/world.h"

namespace rangegrasp::sensing {

/// Options of all simulated range sensors: drop-outs, calibration error, and color camera. The
/// files in models/sensors document the fields.
struct RangeSensorOptions {
  double dropout_begin_rad = base::Deg(60.0);
  double dropout_end_rad = base::Deg(80.0);
  double saturation_angle_rad = base::Deg(5.0);
  double dropout_patch_m = 0.008;  ///< 0: single samples
  // Error of the head's pose that the robot knows: one draw per scan.
  double calibration_sigma_m = 0.001;
  double calibration_sigma_rad = base::Deg(0.1);
  // The color camera sees the room's light.
  bool color = false;
  double color_noise_levels = 2.0;
  double color_gain_sigma = 0.05;
  double color_shift_m = 0.001;  ///< root mean square; rows and columns together
};

/// A laser plane and a camera on a panning head. The origin of the head's frame S (x right, y down,
/// z forward) is the laser's exit point; the pan axis is S's y axis. In the frame P of one profile
/// (S rotated by the pan angle) the laser's fan is the half plane x = 0, z > 0 with its apex in the
/// origin. The camera is at (baseline, 0, 0), rotated about y so that its axis meets the fan at
/// z = focus_distance. "Depth" is z_P.
///
/// Defaults: a 512 x 512 sensor with 9.5 um pixels. Its lens images the whole fan onto the 512
/// columns. Only a window of the rows is read, which ends before the floor behind the table.
struct LineScannerOptions : RangeSensorOptions {
  int samples = 512;  ///< evenly spaced in the tangent of the fan's angle
  int profiles = 150;
  double fan_rad = base::Deg(42.0);
  double pan_range_rad = base::Deg(34.0);
  double baseline_m = 0.30;
  double focal_length_m = 0.0063;
  double pixel_pitch_m = 9.5e-6;
  int sensor_pixels = 256;
  double focus_distance_m = 0.9;
  double near_m = 0.20;
  double line_width_m = 0.001;  ///< of the collimated line
  double blur_px = 2.5;
  double centroid_sigma_px = 0.07;
  double speckle_sigma_m = 0.0002;
  double correlation_samples = 2.0;
  double quantisation_px = 0.0625;  ///< 0: none
  double pan_jitter_rad = base::Deg(0.02);
};

/// Reads models/sensors/*.yaml; missing keys keep their defaults.
/// @throws base::InputError naming file, line and key.
LineScannerOptions ReadLineScanner(const std::filesystem::path& file);
inline constexpr const char* kLineScanner = "line_scanner";

/// @throws std::invalid_argument naming the key (in the units of a sensor file) that is out of
/// range, its value and its range.
void CheckOptions(const LineScannerOptions& options);

enum class DepthPrinciple { kActiveStereo, kTimeOfFlight };
constexpr std::array<std::string_view, 2> WordsOf(DepthPrinciple) {
  return {"active_stereo", "time_of_flight"};
}

/// A camera that measures the depth of each pixel. The origin of its frame S (x right, y down, z
/// forward) is the lens (for stereo, the left lens); the z axis passes through the image center.
/// Pixels are square.
struct DepthCameraOptions : RangeSensorOptions {
  DepthPrinciple principle = DepthPrinciple::kActiveStereo;
  int width = 640;
  int height = 480;
  double field_right_rad = base::Deg(75.0);
  double min_depth_m = 0.20;
  double max_depth_m = 3.0;
  int frames = 1;

  // Active stereo
  double baseline_m = 0.05;
  double disparity_sigma_px = 0.08;
  double disparity_step_px = 1.0 / 32.0;  ///< 0: none
  int window_px = 7;
  int window_rows_px = 7;
  double fixed_share = 0.5;

  // Time of flight
  double range_sigma_m = 0.0012;
  double range_offset_m = 0.003;  ///< error of all ranges, root mean square; one draw per scan

  // Depth edges
  double edge_reach_px = 3.0;
  double edge_loss = 0.1;
  double flying_share = 0.05;
  double lateral_sigma_px = 0.8;

  std::string site = "scanner";    ///< site in the scene; one on the arm moves with it
  std::optional<base::Pose> X_WS;  ///< used instead of a site
};

/// Reads models/sensors/depth_camera_*.yaml; missing keys keep their defaults.
/// @throws base::InputError naming file, line and key.
DepthCameraOptions ReadDepthCamera(const std::filesystem::path& file);
inline constexpr const char* kDepthCamera = "depth_camera";

/// Focal length [px]: f = (width / 2) / tan(field / 2).
double FocalLength(const DepthCameraOptions& options);

/// State of a sample of the range image. A sample is a laser ray, so surfaces in the laser's shadow
/// have no samples (see ClassifySurface).
enum class SampleState : std::uint8_t {
  kMeasured,
  kCameraShadow,  ///< lit by the laser, within the camera's view, but hidden from the camera
  kDropout,       ///< seen, but lost to grazing incidence, low albedo, gloss or clarity
  kOutOfView      ///< the ray hits no surface, or its spot lies outside the sensor's window
};

/// Ground truth that only the scorer may read, in the layout of the image. A measured sample has
/// the surface that returned most of its light, any other the first surface that the ray hits.
struct ScanTruth {
  std::vector<SampleState> state;
  std::vector<std::uint32_t> label;  ///< 0 if the ray hits no surface
  std::vector<double> true_range_m;  ///< from the laser to the surface; NaN without one
};

struct Scan {
  /// The robot's data: points in W, by the nominal calibration X_WS and the nominal pan angles. The
  /// only origin is the laser's exit point; X_CV is X_WS; noise_m is DepthSigma at the sample's
  /// measured depth, converted to the ray's direction; spacing_m is geometry::MedianSpacing.
  geometry::View view;
  ScanTruth truth;
};

/// A scan of this size, from the pose that the robot knows, in which nothing is measured yet.
Scan EmptyScan(int profiles, int samples, const base::Pose& X_WS);

/// A range sensor: its samples are rays from one head.
using RangeSensor = std::variant<LineScannerOptions, DepthCameraOptions>;

/// Reads a sensor's file of either type. @throws base::InputError naming file, line and key.
RangeSensor ReadRangeSensor(const std::filesystem::path& file);

const RangeSensorOptions& SharedOf(const RangeSensor& sensor);
RangeSensorOptions& SharedOf(RangeSensor& sensor);

/// Field of view in the sensor's frame S.
geometry::Field FieldOf(const RangeSensor& sensor);

/// The sensor's pose in a world. @throws base::InputError if the scene does not have its site
base::Pose PoseIn(const sim::World& world, const RangeSensor& sensor);

Scan ScanScene(std::span<const sim::VisualMesh> meshes, const base::Pose& X_WS,
               const RangeSensor& sensor, base::Rng& rng);

}  // namespace rangegrasp::sensing
