#include "tasks/grasping/sensor_files.h"

#include "core/yaml_map.h"

namespace rangegrasp::tasks::grasping {

SensorFiles ReadSensorFiles(const std::filesystem::path& file) {
  SensorFiles files;
  if (file.empty()) return files;
  core::YamlMap map = core::YamlMap::FromFile(file);
  map.Read("type", files.kind);
  if (files.kind == SensorKind::kLineScanner) files.laser = file;
  if (files.kind == SensorKind::kStereoCamera) files.stereo = file;
  if (files.kind != SensorKind::kLaserAndStereo) return files;
  for (const char* key : {"laser", "stereo"}) map.Require(key);
  map.ReadPath("laser", files.laser, "file of the line scanner");
  map.ReadPath("stereo", files.stereo, "file of the stereo camera");
  map.Finish();
  return files;
}

}  // namespace rangegrasp::tasks::grasping
