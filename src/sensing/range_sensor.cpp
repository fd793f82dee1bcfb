#include "sensing/range_sensor.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/yaml_map.h"
#include "sensing/depth_camera.h"
#include "sensing/optics.h"

namespace rangegrasp::sensing {
namespace {

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
