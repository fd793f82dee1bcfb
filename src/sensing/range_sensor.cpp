#include "sensing/range_sensor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/yaml_map.h"
#include "sensing/depth_camera.h"
#include "sensing/line_scanner.h"
#include "sensing/optics.h"

namespace rangegrasp::sensing {
namespace {

using base::kDeg;
using base::kMm;
using Eigen::Vector3d;

// Every key with its option and range. models/sensors/line_scanner.yaml and depth_camera_*.yaml
// document them.
// @tparam Source  a file (base::YamlMap), or a check of ranges (base::RangeCheck)
template <typename Source, typename Options>
void ReadSharedKeys(Source& from, Options& o) {
  from.ReadScaled("dropout_begin_deg", o.dropout_begin_rad, kDeg, 0.0, 90.0);
  from.ReadScaled("dropout_end_deg", o.dropout_end_rad, kDeg, 0.0, 90.0);
  from.ReadScaled("saturation_angle_deg", o.saturation_angle_rad, kDeg, 0.0, 180.0);
  from.ReadScaled("dropout_patch_mm", o.dropout_patch_m, kMm, 0.0, 1000.0);
  from.ReadScaled("calibration_sigma_mm", o.calibration_sigma_m, kMm, 0.0, 1000.0);
  from.ReadScaled("calibration_sigma_deg", o.calibration_sigma_rad, kDeg, 0.0, 90.0);
  from.Read("color", o.color);
  from.Read("color_noise_levels", o.color_noise_levels, 0.0, 255.0);
  from.Read("color_gain_sigma", o.color_gain_sigma, 0.0, 1.0);
  from.ReadScaled("color_shift_mm", o.color_shift_m, kMm, 0.0, 100.0);
}

constexpr char kDropoutsDoNotBegin[] = "dropout_begin_deg must be less than dropout_end_deg";

bool DropoutsBegin(const RangeSensorOptions& options) {
  return options.dropout_begin_rad < options.dropout_end_rad;
}

/// Finishes reading a sensor's file. @throws base::InputError for an unknown key, or unless
/// dropout_begin is less than dropout_end.
void FinishShared(const base::YamlMap& map, const RangeSensorOptions& options) {
  map.Finish();
  if (DropoutsBegin(options)) return;
  map.Fail(map.Has("dropout_begin_deg") ? "dropout_begin_deg" : "dropout_end_deg",
           kDropoutsDoNotBegin);
}

constexpr double kMicrometer = 1e-6;

template <typename Source, typename Options>
void ReadKeys(Source& from, Options& o) {
  from.Read("samples", o.samples, 2, 8192);
  from.Read("profiles", o.profiles, 1, 8192);
  from.ReadScaled("fan_deg", o.fan_rad, kDeg, 0.1, 120.0);
  from.ReadScaled("pan_range_deg", o.pan_range_rad, kDeg, 0.0, 180.0);
  from.ReadScaled("baseline_mm", o.baseline_m, kMm, 1.0, 5000.0);
  from.ReadScaled("focal_length_mm", o.focal_length_m, kMm, 0.5, 500.0);
  from.ReadScaled("pixel_pitch_um", o.pixel_pitch_m, kMicrometer, 0.1, 100.0);
  from.Read("sensor_pixels", o.sensor_pixels, 8, 65536);
  from.ReadScaled("focus_distance_mm", o.focus_distance_m, kMm, 10.0, 100000.0);
  from.ReadScaled("near_mm", o.near_m, kMm, 10.0, 10000.0);
  from.ReadScaled("line_width_mm", o.line_width_m, kMm, 0.0, 50.0);
  from.Read("blur_px", o.blur_px, 0.0, 100.0);
  from.Read("centroid_sigma_px", o.centroid_sigma_px, 0.0, 100.0);
  from.ReadScaled("speckle_sigma_mm", o.speckle_sigma_m, kMm, 0.0, 100.0);
  from.Read("correlation_samples", o.correlation_samples, 0.01, 10000.0);
  from.Read("quantisation_px", o.quantisation_px, 0.0, 100.0);
  from.ReadScaled("pan_jitter_deg", o.pan_jitter_rad, kDeg, 0.0, 10.0);
  ReadSharedKeys(from, o);
}

// Maximum coordinate in a file: far beyond any work cell, but small enough to detect a wrong unit.
constexpr double kFarthest_mm = 1e5;

void ReadCameraKeys(base::YamlMap& from, DepthCameraOptions& o) {
  from.Read("width_px", o.width, 2, 4096);
  from.Read("height_px", o.height, 2, 4096);
  from.ReadScaled("field_deg", o.field_right_rad, kDeg, 1.0, 150.0);
  from.ReadScaled("min_depth_mm", o.min_depth_m, kMm, 1.0, 100000.0);
  from.ReadScaled("max_depth_mm", o.max_depth_m, kMm, 1.0, 100000.0);
  from.Read("frames", o.frames, 1, 1000);
  from.ReadScaled("baseline_mm", o.baseline_m, kMm, 1.0, 5000.0);
  from.Read("disparity_sigma_px", o.disparity_sigma_px, 0.0, 10.0);
  from.Read("disparity_step_px", o.disparity_step_px, 0.0, 10.0);
  from.Read("window_px", o.window_px, 1, 63);
  from.Read("window_rows_px", o.window_rows_px, 1, 63);
  from.Read("fixed_share", o.fixed_share, 0.0, 1.0);
  from.ReadScaled("range_sigma_mm", o.range_sigma_m, kMm, 0.0, 1000.0);
  from.ReadScaled("range_offset_mm", o.range_offset_m, kMm, 0.0, 1000.0);
  from.Read("edge_reach_px", o.edge_reach_px, 0.0, 32.0);
  from.Read("edge_loss", o.edge_loss, 0.0, 1.0);
  from.Read("flying_share", o.flying_share, 0.0, 1.0);
  from.Read("lateral_sigma_px", o.lateral_sigma_px, 0.0, 10.0);
  ReadSharedKeys(from, o);
}

/// The pose of a camera at `from` whose axis points to `to`. Its x axis is horizontal. For a camera
/// that looks straight up or down it is W's y axis.
base::Pose Looking(const Vector3d& from, const Vector3d& to) {
  constexpr double kVertical = 1e-6;
  const Vector3d z = (to - from).normalized();
  const Vector3d right = z.cross(Vector3d::UnitZ());
  Eigen::Matrix3d R;
  R.col(0) = right.norm() > kVertical ? right.normalized() : Vector3d::UnitY().eval();
  R.col(1) = z.cross(R.col(0)).normalized();
  R.col(2) = R.col(0).cross(R.col(1));
  return base::MakePose(R, from);
}

void ReadPlace(base::YamlMap& map, DepthCameraOptions& options) {
  map.Read("site", options.site);
  if (!map.HoldsMap("place")) return;
  if (map.Has("site")) map.Fail("site", "cannot be used with place: give one of the two");
  base::YamlMap place = map.Child("place");
  Vector3d from, to;
  const auto read = [&](const char* key, double& value) {
    place.Require(key);
    place.ReadScaled(key, value, kMm, -kFarthest_mm, kFarthest_mm);
  };
  read("x_mm", from.x());
  read("look_x_mm", to.x());
  read("y_mm", from.y());
  read("look_y_mm", to.y());
  read("z_mm", from.z());
  read("look_z_mm", to.z());
  place.Finish();
  if (from == to) {
    map.Fail("place",
             "the camera's position and the point that it looks at are the same; change look_z_mm");
  }
  options.X_WS = Looking(from, to);
}

constexpr double kFarthest_m = 10.0;

geometry::Field Field(const LineScannerOptions& scanner) {
  const CameraModel camera(scanner);
  const double half_px = 0.5 * scanner.sensor_pixels;
  return {.half_right_rad = 0.5 * scanner.pan_range_rad,
          .half_down_rad = 0.5 * scanner.fan_rad,
          .near_m = std::max(scanner.near_m, camera.Depth(-half_px).value_or(0.0)),
          .far_m = std::min(kFarthest_m, camera.Depth(half_px).value_or(kFarthest_m))};
}

geometry::Field Field(const DepthCameraOptions& camera) {
  return {.half_right_rad = 0.5 * camera.field_right_rad,
          .half_down_rad = std::atan(0.5 * camera.height / FocalLength(camera)),
          .near_m = camera.min_depth_m,
          .far_m = camera.max_depth_m};
}

}  // namespace

LineScannerOptions ReadLineScanner(const std::filesystem::path& file) {
  auto map = base::YamlMap::FromFile(file);
  std::string type = kLineScanner;
  map.Read("type", type, {kLineScanner}, "type of the sensor");
  for (const char* key : {"place", "site", "pose", "position"}) {
    if (!map.Has(key)) continue;
    map.Fail(key,
             "a line scanner stands at the scene's site \"scanner\", on the wrist at "
             "\"wrist_scanner\": move that site (scenes/bench.xml has the first)");
  }
  LineScannerOptions options;
  ReadKeys(map, options);
  FinishShared(map, options);
  return options;
}

void CheckOptions(const LineScannerOptions& options) {
  const std::string what = "line scanner";
  const base::RangeCheck check(what);
  ReadKeys(check, options);
  if (!DropoutsBegin(options)) throw std::invalid_argument(what + ": " + kDropoutsDoNotBegin);
}

DepthCameraOptions ReadDepthCamera(const std::filesystem::path& file) {
  auto map = base::YamlMap::FromFile(file);
  std::string type = kDepthCamera;
  map.Read("type", type, {kDepthCamera}, "type of the sensor");
  DepthCameraOptions options;
  map.Read("principle", options.principle);
  ReadCameraKeys(map, options);
  ReadPlace(map, options);
  FinishShared(map, options);
  if (options.min_depth_m >= options.max_depth_m) {
    map.Fail(map.Has("min_depth_mm") ? "min_depth_mm" : "max_depth_mm",
             "min_depth_mm must be less than max_depth_mm");
  }
  return options;
}

double FocalLength(const DepthCameraOptions& options) {
  return 0.5 * options.width / std::tan(0.5 * options.field_right_rad);
}

Scan EmptyScan(int profiles, int samples, const base::Pose& X_WS) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::size_t size = std::size_t(profiles) * samples;
  Scan scan;
  scan.view.image = {.profiles = profiles,
                     .samples = samples,
                     .points_C = geometry::Points(size, Vector3d::Constant(nan)),
                     .origins_C = {X_WS.translation()}};
  scan.view.X_CV = X_WS;
  scan.view.noise_m.assign(size, std::numeric_limits<float>::quiet_NaN());
  scan.truth.state.assign(size, SampleState::kOutOfView);
  scan.truth.label.assign(size, 0);
  scan.truth.true_range_m.assign(size, nan);
  return scan;
}

RangeSensor ReadRangeSensor(const std::filesystem::path& file) {
  const std::vector<std::string> words = {kLineScanner, kDepthCamera};
  std::string type = words.front();
  base::YamlMap::FromFile(file).Read("type", type, words, "type of the sensor");
  if (type == kDepthCamera) return ReadDepthCamera(file);
  return ReadLineScanner(file);
}

const RangeSensorOptions& SharedOf(const RangeSensor& sensor) {
  return std::visit(
      [](const RangeSensorOptions& shared) -> const RangeSensorOptions& { return shared; }, sensor);
}
RangeSensorOptions& SharedOf(RangeSensor& sensor) {
  return std::visit([](RangeSensorOptions& shared) -> RangeSensorOptions& { return shared; },
                    sensor);
}

geometry::Field FieldOf(const RangeSensor& sensor) {
  return std::visit([](const auto& options) { return Field(options); }, sensor);
}

base::Pose PoseIn(const sim::World& world, const RangeSensor& sensor) {
  const auto* camera = std::get_if<DepthCameraOptions>(&sensor);
  if (camera == nullptr) return world.SitePose("scanner");
  return camera->X_WS ? *camera->X_WS : world.SitePose(camera->site);
}

Scan ScanScene(std::span<const sim::VisualMesh> meshes, const base::Pose& X_WS,
               const RangeSensor& sensor, base::Rng& rng) {
  return std::visit([&](const auto& options) { return ScanScene(meshes, X_WS, options, rng); },
                    sensor);
}

}  // namespace rangegrasp::sensing
