#include "experiment/experiment_file.h"

#include <algorithm>
#include <regex>
#include <set>

#include "core/error.h"
#include "core/file.h"
#include "core/hash.h"
#include "core/units.h"
#include "core/yaml_map.h"

namespace rangegrasp::experiment {
namespace {

using core::Deg;
using core::YamlMap;

constexpr double kMm = 1e-3;
constexpr double kDeg = core::kPi / 180.0;

void ReadPhysics(YamlMap map, sim::PhysicsOptions& options) {
  map.ReadScaled("timestep_ms", options.timestep_s, kMm, 0.1, 4.0);
  map.Read("static_friction_offset", options.static_friction_offset, -0.5, 0.5);
  map.Read("kinetic_only", options.kinetic_only);
  map.Read("glove_friction", options.glove_friction, 0.0, 2.0);
  map.Finish();
}

void ReadHand(YamlMap map, sim::HandControlOptions& options) {
  map.Read("initial_force_n", options.initial_force_N, 5.0, 100.0);
  map.Read("max_force_n", options.max_force_N, 5.0, 100.0);
  map.Read("slip_control", options.slip_control);
  if (options.initial_force_N > options.max_force_N) {
    map.Fail(map.Has("max_force_n") ? "max_force_n" : "initial_force_n",
             "the first grip (" + std::to_string(options.initial_force_N) +
                 " N) must not be stronger than the strongest (" +
                 std::to_string(options.max_force_N) + " N)");
  }
  map.Finish();
}

void ReadPerception(YamlMap map, perception::PerceptionOptions& options) {
  map.ReadEnum("segmentation", options.segment.method, {"mesh", "region_growing"});
  map.Read("filter", options.preprocess.filter);
  map.Read("smooth", options.preprocess.smooth);
  map.ReadScaled("normal_radius_mm", options.preprocess.normal_radius_m, kMm, 1.0, 50.0);
  map.ReadScaled("plane_distance_mm", options.preprocess.plane_distance_m, kMm, 0.2, 50.0);
  map.ReadScaled("table_clearance_mm", options.preprocess.table_clearance_m, kMm, 0.0, 50.0);
  auto& features = options.features;
  map.Read("ridge_tops", features.ridge_tops);
  map.Read("top_plane_share", features.top_plane_share, 0.0, 1.0);
  map.Read("axis_from_body", features.axis_from_body);
  map.Read("merge_fragments", features.merge_fragments);
  map.Read("complete_by_symmetry", features.complete_by_symmetry);
  map.Read("open_stray_share", features.open_stray_share, 0.0, 1.0);
  map.ReadScaled("least_footprint_mm", features.least_footprint_m, kMm, 0.0, 100.0);
  map.Finish();
}

void ReadGrasp(YamlMap map, grasp::GraspOptions& options) {
  map.Read("refine", options.refine);
  map.ReadScaled("table_clearance_mm", options.table_clearance_m, kMm, 0.0, 50.0);
  map.Read("most", options.most, 1, 200);
  map.Finish();
}

void ReadPlanning(YamlMap map, planning::PlanOptions& options) {
  map.ReadScaled("approach_mm", options.approach_m, kMm, 20.0, 400.0);
  map.ReadScaled("lift_mm", options.lift_m, kMm, 100.0, 400.0);
  map.Finish();
}

void CheckObjects(const YamlMap& map, const Experiment& experiment) {
  if (!std::filesystem::is_directory(experiment.object_folder)) {
    map.Fail("object_folder", "no folder " + experiment.object_folder.string() +
                                  " (it must hold <name>/<name>.xml for every object)");
  }
  std::set<std::string> seen;
  for (const std::string& object : experiment.objects) {
    if (!seen.insert(object).second) map.Fail("objects", "names '" + object + "' twice");
    const auto mjcf = ObjectModelOf(experiment, object).mjcf;
    if (std::filesystem::is_regular_file(mjcf)) continue;
    std::vector<std::string> known;
    for (const auto& entry : std::filesystem::directory_iterator(experiment.object_folder)) {
      known.push_back(entry.path().filename().string());
    }
    std::sort(known.begin(), known.end());
    map.Fail("objects", "no object '" + object + "' (no file " + mjcf.string() + "); nearest: '" +
                            core::NearestWord(object, known) + "'");
  }
}

}  // namespace

Experiment ReadExperiment(const std::filesystem::path& file) {
  Experiment e;
  e.file = file;
  YamlMap map = YamlMap::FromFile(file);
  for (const char* key : {"name", "scene", "sensor", "objects"}) map.Require(key);
  map.Read("name", e.name);
  if (!std::regex_match(e.name, std::regex("[A-Za-z0-9_-]+"))) {
    map.Fail("name", "'" + e.name + "' must be letters, digits, '_' and '-': it names a folder");
  }
  map.ReadPath("scene", e.scene);
  map.ReadEnum("arrangement", e.arrangement, {"single"});
  map.ReadPath("sensor", e.sensor);
  map.ReadPath("reference", e.reference);
  e.object_folder = (file.parent_path() / "../models/objects").lexically_normal();
  map.ReadPath("object_folder", e.object_folder);
  map.Read("objects", e.objects);
  map.Read("trials_per_object", e.trials_per_object, 1, 100000);
  map.Read("seed", e.seed);
  map.Read("trial_limit_s", e.trial_limit_s, 1.0, 3600.0);
  map.Read("most_plans", e.most_plans, 1, 200);
  map.ReadScaled("workspace_margin_mm", e.workspace_margin_m, kMm, 50.0, 1000.0);
  map.ReadScaled("min_tipping_deg", e.min_tipping_rad, kDeg, 0.0, 45.0);
  ReadPhysics(map.Child("physics"), e.physics);
  ReadHand(map.Child("hand"), e.hand);
  ReadPerception(map.Child("perception"), e.perception);
  ReadGrasp(map.Child("grasp"), e.grasp);
  ReadPlanning(map.Child("planning"), e.planning);
  map.Finish();
  CheckObjects(map, e);
  return e;
}

sim::ObjectModel ObjectModelOf(const Experiment& experiment, const std::string& object) {
  return {object, experiment.object_folder / object / (object + ".xml")};
}

std::string ExperimentHash(const Experiment& experiment) {
  // Seed, objects and the number of trials stand in the stamp by themselves and may be set on the
  // command line: the hash leaves their lines out, so that runs that differ in nothing else can be
  // recognised.
  const std::string text = core::ReadNonEmptyFile(experiment.file);
  std::uint64_t hash = core::Fnv1a("");
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    if (!line.starts_with("seed:") && !line.starts_with("trials_per_object:")) {
      hash = core::Fnv1a(line + "\n", hash);
    }
    begin = end + 1;
  }
  return core::Hex(hash);
}

namespace {

// Adds an MJCF file and, by its file="..." attributes, what it refers to.
void CollectModelFiles(const std::filesystem::path& file, std::set<std::filesystem::path>& files) {
  const auto path = file.lexically_normal();
  if (!std::filesystem::is_regular_file(path) || !files.insert(path).second) return;
  if (path.extension() != ".xml") return;
  const std::string text = core::ReadNonEmptyFile(path);
  static const std::regex kFile("file=\"([^\"]+)\"");
  for (auto it = std::sregex_iterator(text.begin(), text.end(), kFile);
       it != std::sregex_iterator(); ++it) {
    CollectModelFiles(path.parent_path() / (*it)[1].str(), files);
  }
}

}  // namespace

std::string SceneHash(const Experiment& experiment) {
  std::set<std::filesystem::path> files;
  CollectModelFiles(experiment.scene, files);
  for (const std::string& object : experiment.objects) {
    CollectModelFiles(ObjectModelOf(experiment, object).mjcf, files);
  }
  files.insert(experiment.sensor);
  // By name, not by path: the same files in another folder hash alike.
  std::vector<std::pair<std::string, std::filesystem::path>> sorted;
  for (const auto& file : files) sorted.emplace_back(file.filename().string(), file);
  std::sort(sorted.begin(), sorted.end());
  std::uint64_t hash = core::Fnv1a("");
  for (const auto& [name, file] : sorted) {
    hash = core::Fnv1a(name + core::ReadNonEmptyFile(file), hash);
  }
  return core::Hex(hash);
}

}  // namespace rangegrasp::experiment
