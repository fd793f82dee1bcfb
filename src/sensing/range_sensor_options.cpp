#include "sensing/range_sensor_options.h"

#include <cmath>
#include <stdexcept>

#include "base/yaml_map.h"

namespace rangegrasp::sensing {
namespace {

using base::kDeg;
using base::kMm;
using Eigen::Vector3d;

/// Every shared key with its option, range and documentation.
/// @tparam Source  a file (base::YamlMap), or a check of ranges (base::RangeCheck)
template <typename Source, typename Options>
void ReadSharedKeys(Source& from, Options& o) {
  from.ReadScaled("dropout_begin_deg", o.dropout_begin_rad, kDeg, 0.0, 90.0,
                  "angle of incidence above which samples are lost");
  from.ReadScaled("dropout_end_deg", o.dropout_end_rad, kDeg, 0.0, 90.0,
                  "angle of incidence above which all samples are lost");
  from.ReadScaled("saturation_angle_deg", o.saturation_angle_rad, kDeg, 0.0, 180.0,
                  "angle to the mirror direction below which gloss blinds the camera");
  from.ReadScaled("dropout_patch_mm", o.dropout_patch_m, kMm, 0.0, 1000.0,
                  "size of the patches of samples that are lost together because of incidence or "
                  "gloss; 0: single samples");
  from.ReadScaled("calibration_sigma_mm", o.calibration_sigma_m, kMm, 0.0, 1000.0,
                  "calibration error of the head's position, root mean square");
  from.ReadScaled("calibration_sigma_deg", o.calibration_sigma_rad, kDeg, 0.0, 90.0,
                  "calibration error of the head's orientation, root mean square");
  from.Read("color", o.color, "the sensor also measures each sample's color, in the room's light");
  from.Read("color_noise_levels", o.color_noise_levels, 0.0, 255.0, "noise of the color, of 255");
  from.Read("color_gain_sigma", o.color_gain_sigma, 0.0, 1.0,
            "error of the color channels' balance, relative; one draw per channel and scan");
  from.ReadScaled("color_shift_mm", o.color_shift_m, kMm, 0.0, 100.0,
                  "distance between a sample and its color, root mean square; one draw per scan");
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

/// Every key with its option, range and documentation. The source is a file or a check of ranges.
template <typename Source, typename Options>
void ReadKeys(Source& from, Options& o) {
  from.Read("samples", o.samples, 2, 8192, "number of points of a profile, along the line");
  from.Read("profiles", o.profiles, 1, 8192, "number of profiles of a scan");
  from.ReadScaled("fan_deg", o.fan_rad, kDeg, 0.1, 120.0,
                  "opening angle of the laser's fan, and of the camera along the line");
  from.ReadScaled(
      "pan_range_deg", o.pan_range_rad, kDeg, 0.0, 180.0,
      "angle between the first and the last profile, symmetric about the forward direction");
  from.ReadScaled("baseline_mm", o.baseline_m, kMm, 1.0, 5000.0,
                  "distance from the laser to the camera");
  from.ReadScaled("focal_length_mm", o.focal_length_m, kMm, 0.5, 500.0,
                  "focal length of the camera's lens");
  from.ReadScaled("pixel_pitch_um", o.pixel_pitch_m, kMicrometer, 0.1, 100.0,
                  "pixel size of the camera");
  from.Read("sensor_pixels", o.sensor_pixels, 8, 65536,
            "number of pixels that are read across the line; this limits the measurable depths");
  from.ReadScaled("focus_distance_mm", o.focus_distance_m, kMm, 10.0, 100000.0,
                  "depth at which the camera's axis meets the laser's plane");
  from.ReadScaled("near_mm", o.near_m, kMm, 10.0, 10000.0,
                  "minimum depth; anything nearer to the head is ignored");
  from.ReadScaled("line_width_mm", o.line_width_m, kMm, 0.0, 50.0,
                  "1/e^2 width of the line on a surface");
  from.Read("blur_px", o.blur_px, 0.0, 100.0,
            "1/e^2 width that lens and pixels add to the line's image");
  from.Read("centroid_sigma_px", o.centroid_sigma_px, 0.0, 100.0,
            "white noise of the peak's centroid");
  from.ReadScaled("speckle_sigma_mm", o.speckle_sigma_m, kMm, 0.0, 100.0,
                  "depth noise by speckle at a depth of 1 m, growing with the squared distance");
  from.Read("correlation_samples", o.correlation_samples, 0.01, 10000.0,
            "1/e length of the speckle along the line, in samples");
  from.Read("quantisation_px", o.quantisation_px, 0.0, 100.0,
            "resolution of the centroid; 0: none");
  from.ReadScaled("pan_jitter_deg", o.pan_jitter_rad, kDeg, 0.0, 10.0,
                  "standard deviation of the pan angle, one value per profile");
  ReadSharedKeys(from, o);
}

// Maximum coordinate in a file: far beyond any work cell, but small enough to detect a wrong unit.
constexpr double kFarthest_mm = 1e5;

/// Every key with its option, range and documentation.
void ReadCameraKeys(base::YamlMap& from, DepthCameraOptions& o) {
  from.Read("width_px", o.width, 2, 4096, "columns of the depth image");
  from.Read("height_px", o.height, 2, 4096, "rows of the depth image");
  from.ReadScaled("field_deg", o.field_right_rad, kDeg, 1.0, 150.0,
                  "horizontal field of view; pixels are square");
  from.ReadScaled("min_depth_mm", o.min_depth_m, kMm, 1.0, 100000.0, "minimum measurable depth");
  from.ReadScaled("max_depth_mm", o.max_depth_m, kMm, 1.0, 100000.0, "maximum measurable depth");
  from.Read("frames", o.frames, 1, 1000,
            "number of images that are averaged; reduces the noise that differs between images");
  from.ReadScaled("baseline_mm", o.baseline_m, kMm, 1.0, 5000.0,
                  "active stereo: distance between the two lenses");
  from.Read("disparity_sigma_px", o.disparity_sigma_px, 0.0, 10.0,
            "active stereo: noise of the disparity; the depth's is z^2 / (f b) times that");
  from.Read("disparity_step_px", o.disparity_step_px, 0.0, 10.0,
            "active stereo: resolution of the disparity; 0: none");
  from.Read("window_px", o.window_px, 1, 63,
            "active stereo: columns over which the matching averages: neighbors' errors are alike");
  from.Read("window_rows_px", o.window_rows_px, 1, 63, "active stereo: rows of that window");
  from.Read("fixed_share", o.fixed_share, 0.0, 1.0,
            "share of the noise's variance that is the same in all images of a scene");
  from.ReadScaled("range_sigma_mm", o.range_sigma_m, kMm, 0.0, 1000.0,
                  "time of flight: noise at 1 m on a white surface that faces the camera; grows "
                  "with the range and the inverse root of the reflected light");
  from.ReadScaled("range_offset_mm", o.range_offset_m, kMm, 0.0, 1000.0,
                  "time of flight: error of all ranges, root mean square; one draw per scan");
  from.Read("edge_reach_px", o.edge_reach_px, 0.0, 32.0,
            "distance from a depth edge within which samples are lost, mixed or moved across it");
  from.Read("edge_loss", o.edge_loss, 0.0, 1.0, "share of these samples that are lost");
  from.Read("flying_share", o.flying_share, 0.0, 1.0,
            "share of the other samples there that lie between the two surfaces (flying pixels)");
  from.Read("lateral_sigma_px", o.lateral_sigma_px, 0.0, 10.0,
            "noise of the place of depth edges in the image");
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
  map.Read("site", options.site,
           "site of the scene where the camera stands, x right, y down, z forward; a site on the "
           "arm moves with it");
  if (!map.HoldsMap("place")) return;
  if (map.Has("site")) map.Fail("site", "cannot be used with place: give one of the two");
  base::YamlMap place = map.Child("place", "where the camera stands instead, in world W");
  Vector3d from, to;
  const std::array<const char*, 3> from_keys = {"x_mm", "y_mm", "z_mm"};
  const std::array<const char*, 3> to_keys = {"look_x_mm", "look_y_mm", "look_z_mm"};
  for (int axis = 0; axis < 3; ++axis) {
    const auto read = [&](const char* key, double& value, const char* doc) {
      place.Require(key);
      place.ReadScaled(key, value, kMm, -kFarthest_mm, kFarthest_mm, doc);
    };
    read(from_keys[axis], from[axis], "position of the lens");
    read(to_keys[axis], to[axis], "point in the middle of the image");
  }
  place.Finish();
  if (from == to) {
    map.Fail("place",
             "the camera's position and the point that it looks at are the same; change look_z_mm");
  }
  options.X_WS = Looking(from, to);
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
  map.Read("principle", options.principle, "how depth is measured");
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

}  // namespace rangegrasp::sensing
