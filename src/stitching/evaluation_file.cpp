#include <algorithm>

#include "core/error.h"
#include "core/units.h"
#include "core/yaml_map.h"
#include "stitching/evaluation.h"

namespace rangegrasp::stitching {
namespace {

using core::YamlMap;

constexpr double kMm = 1e-3;
constexpr int kMostSeams = 1'000'000;

std::vector<std::string> ShapeNames() {
  std::vector<std::string> names;
  for (int shape = 0; shape <= static_cast<int>(EdgeShape::kNone); ++shape) {
    names.emplace_back(Name(static_cast<EdgeShape>(shape)));
  }
  return names;
}

void ReadShapes(YamlMap& map, std::vector<EdgeShape>& shapes) {
  std::vector<std::string> words;
  map.Read("shapes", words);
  if (words.empty()) return;
  const auto names = ShapeNames();
  shapes.clear();
  for (const std::string& word : words) {
    const auto found = std::find(names.begin(), names.end(), word);
    if (found == names.end()) {
      map.Fail("shapes", "'" + word + "' is no shape of edge; nearest: '" +
                             core::NearestWord(word, names) + "'");
    }
    shapes.push_back(static_cast<EdgeShape>(found - names.begin()));
  }
}

void ReadTexture(YamlMap map, MatTexture& texture) {
  map.ReadScaled("weave_period_mm", texture.weave_period_m, kMm, 0.2, 50.0);
  map.ReadScaled("weave_relief_mm", texture.weave_relief_m, kMm, 0.0, 2.0);
  map.ReadScaled("fuzz_mm", texture.fuzz_m, kMm, 0.0, 1.0);
  map.ReadScaled("fray_mm", texture.fray_m, kMm, 0.0, 5.0);
  map.ReadScaled("fray_length_mm", texture.fray_length_m, kMm, 0.2, 100.0);
  map.ReadScaled("filaments_per_mm", texture.filaments_per_m, 1e3, 0.0, 10.0);
  map.ReadScaled("loose_filaments_per_mm2", texture.loose_filaments_per_m2, 1e6, 0.0, 1.0);
  map.ReadScaled("filament_height_mm", texture.filament_height_m, kMm, 0.0, 10.0);
  map.Read("detached_share", texture.detached_share, 0.0, 1.0);
  map.Read("gloss", texture.gloss, 0.0, 1.0);
  map.ReadScaled("steep_deg", texture.steep_rad, core::kPi / 180.0, 1.0, 89.0);
  map.Read("darkness", texture.darkness, 0.0, 1.0);
  map.Finish();
}

void ReadTrack(YamlMap map, TrackOptions& options) {
  map.ReadScaled("wanted_distance_mm", options.wanted_distance_m, kMm, 0.0, 50.0);
  map.ReadScaled("length_mm", options.length_m, kMm, 50.0, 100'000.0);
  map.Read("rotate", options.head.rotate);
  map.ReadScaled("max_lateral_speed_mm_s", options.head.max_lateral_speed_m_s, kMm, 1.0, 2000.0);
  map.ReadScaled("max_acceleration_mm_s2", options.head.max_acceleration_m_s2, kMm, 1.0, 20'000.0);
  map.Read("max_rotation_rad_s", options.head.max_rotation_rad_s, 0.01, 20.0);
  map.Read("max_rotation_acceleration_rad_s2", options.head.max_rotation_acceleration_rad_s2, 0.01,
           200.0);
  map.Finish();
}

void ReadMonitor(YamlMap map, seam::MonitorOptions& options) {
  map.ReadScaled("obstacle_height_mm", options.obstacle_height_m, kMm, 0.5, 100.0);
  map.ReadScaled("obstacle_width_mm", options.obstacle_width_m, kMm, 0.1, 100.0);
  map.Read("obstacle_profiles", options.obstacle_profiles, 1, 1000);
  map.Read("mat_end_profiles", options.mat_end_profiles, 1, 1000);
  map.Read("window", options.window, 1, 1000);
  if (options.window < std::max(options.obstacle_profiles, options.mat_end_profiles)) {
    map.Fail("window", "must not be shorter than obstacle_profiles or mat_end_profiles");
  }
  map.Finish();
}

}  // namespace

Evaluation ReadEvaluation(const std::filesystem::path& file) {
  auto map = YamlMap::FromFile(file);
  Evaluation evaluation;
  evaluation.file = file;
  evaluation.name = file.stem().string();
  map.Read("name", evaluation.name);
  map.ReadEnum("kind", evaluation.kind, {"rates", "tracks", "hazards"});
  map.Require("sensor");
  map.ReadPath("sensor", evaluation.sensor_file);
  evaluation.sensor = ReadStripeSensor(evaluation.sensor_file);
  ReadShapes(map, evaluation.shapes);
  map.Read("seams", evaluation.seams, 1, kMostSeams);
  map.Read("profiles_per_seam", evaluation.profiles_per_seam, 1, kMostSeams);
  map.Read("edge_within", evaluation.edge_within, 0.0, 1.0);
  map.ReadScaled("half_circle_radius_mm", evaluation.half_circle_radius_m, kMm, 0.0, 1000.0);
  map.ReadScaled("speed_mm_s", evaluation.speed_m_s, kMm, 1.0, 500.0);
  map.Read("seed", evaluation.seed);
  map.ReadPath("reference", evaluation.reference);
  map.ReadPath("improvements", evaluation.improvements);
  ReadTexture(map.Child("texture"), evaluation.texture);
  ReadTrack(map.Child("track"), evaluation.track);
  ReadMonitor(map.Child("monitor"), evaluation.track.monitor);
  auto tracker = map.Child("tracker");
  seam::ReadTrackerOptions(tracker, evaluation.track.tracker);
  tracker.Finish();
  map.Finish();
  evaluation.track.tracker.line = evaluation.sensor.line;
  return evaluation;
}

}  // namespace rangegrasp::stitching
