#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "base/frames.h"
#include "base/units.h"
#include "base/yaml_map.h"
#include "sensing/range_sensor_options.h"

namespace rangegrasp::sensing {

enum class DepthPrinciple { kActiveStereo, kTimeOfFlight };
constexpr std::array<std::string_view, 2> WordsOf(DepthPrinciple) {
  return {"active_stereo", "time_of_flight"};
}

/// A camera that measures the depth of each pixel. The origin of its frame S (x right, y down, z
/// forward) is the lens (for stereo, the left lens); the z axis passes through the image center.
/// Pixels are square.
struct DepthCameraOptions : RangeSensorOptions {
  // The keys of depth_camera_options.cpp document the fields.
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
  double disparity_step_px = 1.0 / 32.0;
  int window_px = 7;
  int window_rows_px = 7;
  double fixed_share = 0.5;

  // Time of flight
  double range_sigma_m = 0.0012;
  double range_offset_m = 0.003;

  // Depth edges
  double edge_reach_px = 3.0;
  double edge_loss = 0.1;
  double flying_share = 0.05;
  double lateral_sigma_px = 0.8;

  std::string site = "scanner";    ///< site in the scene
  std::optional<base::Pose> X_WS;  ///< used instead of a site
};

/// Reads models/sensors/depth_camera_*.yaml; missing keys keep their defaults.
/// @throws base::InputError naming file, line and key.
DepthCameraOptions ReadDepthCamera(const std::filesystem::path& file);
inline constexpr const char* kDepthCamera = "depth_camera";

/// Focal length [px]: f = (width / 2) / tan(field / 2).
double FocalLength(const DepthCameraOptions& options);

}  // namespace rangegrasp::sensing
