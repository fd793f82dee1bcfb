#include "trial/options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <ranges>
#include <set>

#include "base/file.h"
#include "base/installation.h"
#include "base/pattern.h"
#include "base/words.h"
#include "perception/perception_options.h"
#include "sim/check/check.h"
#include "sim/surfaces.h"
#include "trial/arranger.h"
#include "trial/registry.h"

namespace rangegrasp::trial {
namespace {

namespace fs = std::filesystem;
using base::kDeg;
using base::kMm;
using base::YamlMap;

// ---- keys of the experiment file ----

void ReadPhysicsOptions(YamlMap map, sim::PhysicsOptions& o) {
  map.ReadScaled("timestep_ms", o.timestep_s, kMm, 0.1, 4.0, "time step of the physics engine");
  map.Read(
      "friction", o.friction,
      "friction of the glove on each object: drawn from its range in each trial; the middle, the "
      "low or the high end of the range; or the kinetic instead of the static coefficient");
  map.Read("glove_friction", o.glove_friction, 0.0, 2.0,
           "one friction coefficient of the glove for all objects, instead of the table of pairs");
  map.Finish();
}

void ReadHandOptions(YamlMap map, double& firm_from_rad, sim::HandControlOptions& o) {
  map.Read("initial_force_n", o.initial_force_N, 5.0, 100.0,
           "first grip force at the fingertips; default: the hand's own");
  map.Read("max_force_n", o.max_force_N, 5.0, 100.0, "maximum grip force; default: the hand's own");
  map.ReadScaled("firm_from_deg", firm_from_rad, kDeg, 0.0, 90.0,
                 "faces that are tilted by more than this are gripped with the maximum force at "
                 "once; 90: none");
  map.Read("slip_control", o.slip_control, "increase the grip force while the object slips");
  map.ReadScaled("slip_threshold_mm_s", o.slip_threshold_m_s, kMm, 0.1, 1000.0,
                 "minimum sliding speed at the distal pads that the slip sensors detect");
  map.ReadScaled("slip_delay_ms", o.slip_delay_s, 1e-3, 0.0, 1000.0,
                 "delay between slip and its signal at the controller");
  map.ReadScaled("slip_noise_mm_s", o.slip_noise_m_s, kMm, 0.0, 1000.0,
                 "standard deviation of the slip signal");
  if (o.initial_force_N && o.max_force_N && *o.initial_force_N > *o.max_force_N) {
    map.Fail(map.Has("max_force_n") ? "max_force_n" : "initial_force_n",
             fmt::format("the first grip ({:g} N) must not be stronger than the strongest ({:g} N)",
                         *o.initial_force_N, *o.max_force_N));
  }
  map.Finish();
}

void ReadClutterOptions(YamlMap map, ClutterOptions& o, std::optional<double>& box_wall_m) {
  map.Read("always", o.always, "scattered: objects that are present in every trial");
  map.Read("others", o.others,
           "scattered: objects from which the others are drawn (default: those of `objects`)");
  map.Read("standing_share", o.standing_share, 0.0, 1.0,
           "scattered: probability that the target and the objects of `always` stand upright; "
           "default: that of a drop");
  map.ReadScaled(
      "scatter_radius_mm", o.scatter_radius_m, kMm, 10.0, 1000.0,
      "scattered: maximum distance of the other objects from the middle of the workspace");
  map.Read("min_others", o.min_others, 1, 30,
           "scattered, touching, side_by_side: minimum number of objects next to the target");
  map.Read("max_others", o.max_others, 1, 30,
           "scattered, touching, side_by_side: maximum number of objects next to the target");
  map.Read("draw_others", o.draw_others,
           "box, pile: also draw the number of other objects at random; off: use all others");
  std::optional<double> box_wall_mm;
  map.Read("box_wall_mm", box_wall_mm, 10.0, 500.0,
           "inner height of the walls of the scene's box; default: as in the scene");
  if (box_wall_mm) box_wall_m = *box_wall_mm * kMm;
  map.Read("max_draws", o.max_draws, 1, 1000,
           "maximum number of heaps drawn before the trial is given up");
  map.Read("settle_limit_s", o.settle_limit_s, 0.5, 60.0,
           "maximum time until an arrangement is at rest; after that it is drawn again");
  map.ReadScaled("rest_speed_mm_s", o.rest_speed_m_s, kMm, 0.01, 100.0,
                 "maximum speed of an object at rest");
  if (o.min_others > o.max_others) {
    map.Fail(map.Has("max_others") ? "max_others" : "min_others",
             fmt::format("max_others ({}) must be at least min_others ({})", o.max_others,
                         o.min_others));
  }
  map.Finish();
}

// Calls `visit(prefix of their keys, switches)` for all structs of switches.
void VisitSwitches(Options& o, const auto& visit) {
  visit("perception.", static_cast<perception::PreprocessAdditions&>(o.perception.preprocess));
  visit("perception.", static_cast<perception::SegmentAdditions&>(o.perception.segment));
  visit("perception.", static_cast<perception::FeatureAdditions&>(o.perception.features));
  visit("grasp.", static_cast<grasp::GraspAdditions&>(o.grasp));
  visit("planning.", static_cast<grasp::ObstacleAdditions&>(o.obstacles));
  visit("planning.", static_cast<grasp::MoverAdditions&>(o));
}

// Reads a word, or a map whose keys are read by the detector with keys.
void ReadDetector(YamlMap& map, Options& o) {
  o.detector = kDissertation;
  const DetectorKind* with_keys = FindDetector(kDetectorWithKeys);
  const bool holds_keys = map.HoldsMap("detector");
  if (with_keys && (holds_keys || !map.Has("detector"))) {
    with_keys->read(map.Child("detector"), o);
  } else if (holds_keys) {
    map.Child("detector").Finish();  // the error names the system that reads these keys
  }
  if (holds_keys) {
    o.detector = kDetectorWithKeys;
    return;
  }
  map.Read("detector", o.detector, DetectorWords(),
           "grasp detector: the method of chapter 5; a baseline that grasps the highest cluster of "
           "points straight from above, across its short side; or a map with the keys below");
}

// ---- files of objects ----

// The values of an attribute in an MJCF file.
std::vector<std::string> ValuesIn(const std::string& text, const std::string& attribute) {
  std::vector<std::string> values;
  const std::string pattern = attribute + "\\s*=\\s*(?:\"([^\"]+)\"|'([^']+)')";
  for (const auto& match : base::AllMatches(text, pattern)) {
    values.push_back(match.groups[1] + match.groups[2]);  // one of them is empty
  }
  return values;
}

// Adds an MJCF file and the files that its attributes "file" refer to.
// @param folders  in which they may be, in addition to its own folder and those of its <compiler>:
// the folders of the files that include it
void CollectModelFiles(const fs::path& file, std::set<fs::path>& files,
                       std::vector<fs::path> folders = {}) {
  const auto path = file.lexically_normal();
  if (!fs::is_regular_file(path) || !files.insert(path).second) return;
  if (path.extension() != ".xml") return;
  const std::string text = base::ReadFile(path);
  folders.push_back(path.parent_path());
  for (const std::string& folder : ValuesIn(text, "(?:mesh|texture|asset)dir")) {
    folders.push_back(path.parent_path() / folder);
  }
  for (const std::string& name : ValuesIn(text, "file")) {
    for (const fs::path& folder : folders) CollectModelFiles(folder / name, files, folders);
  }
}

// Folder of the objects that come with the program: `next_to`, or else in the data folder.
fs::path ShippedObjects(const fs::path& next_to) {
  if (fs::is_directory(next_to)) return next_to;
  try {
    return base::DataFolder() / "models/objects";
  } catch (const base::InputError&) {
    return next_to;
  }
}

// Names of the objects in all folders, sorted.
std::vector<std::string> KnownObjects(const Options& options) {
  std::set<std::string> known;
  for (const auto& folder : options.object_folders) {
    if (!fs::is_directory(folder)) continue;
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (fs::is_regular_file(entry.path() / (name + ".xml"))) known.insert(name);
    }
  }
  return {known.begin(), known.end()};
}

std::vector<fs::path> ReadObjectFolders(YamlMap& map) {
  const auto resolved = [&](const std::string& path) {
    return (map.file().parent_path() / path).lexically_normal();
  };
  std::vector<std::string> names;
  map.Read("object_folders", names,
           "folders with NAME/NAME.xml for every object, relative to the file; of two objects with "
           "the same name the first is used; the program's own objects are also found");
  std::vector<fs::path> folders;
  for (const std::string& name : names) {
    folders.push_back(resolved(name));
    if (fs::is_directory(folders.back())) continue;
    map.Fail("object_folders", fmt::format("no folder '{}' (looked for {}; paths are relative to "
                                           "the YAML file)",
                                           name, folders.back().string()));
  }
  folders.push_back(ShippedObjects(resolved("../models/objects")));
  return folders;
}

// Errors of the scene and of the objects that exist; CheckObjects reports the missing ones.
std::vector<base::Finding> FindingsOf(const Options& options) {
  auto findings = check::CheckModel(options.scene, check::Kind::kScene);
  for (const std::string& object : AllObjects(options)) {
    const sim::ObjectModel model = ObjectModelOf(options, object);
    if (!fs::is_regular_file(model.mjcf)) continue;
    std::ranges::move(check::CheckObject(model, options.min_tipping_rad),
                      std::back_inserter(findings));
  }
  return findings;
}

}  // namespace

void SetMethod(MethodKind method, Options& options) {
  const bool on = method == MethodKind::kImproved;
  VisitSwitches(options, [&](const char*, auto& switches) { base::SwitchAll(on, switches); });
  options.perception.segment.method =
      on ? perception::SegmentOptions().method : perception::SegmentMethod::kMesh;
  options.score = on ? Options().score : grasp::ScoreKind::kRules;
  options.method = method;
}

std::vector<MethodDifference> MethodDifferences() {
  std::vector<MethodDifference> keys;
  Options any;
  VisitSwitches(any, [&](const std::string& prefix, const auto& switches) {
    for (const auto& row : base::AdditionsTable<std::remove_cvref_t<decltype(switches)>>()) {
      keys.push_back({prefix + std::string(row.key), std::string(row.doc)});
    }
  });
  keys.push_back({"perception.segmentation", "the mesh of section 5.1.2 joins touching objects",
                  "convexity", "mesh"});
  keys.push_back(
      {"grasp.score", "ranks grasps by the predicted probability of delivery", "learned", "rules"});
  return keys;
}

Options ReadOptions(YamlMap& map, std::uint64_t seed) {
  Options o;
  o.seed = seed;
  for (const char* key : {"scene", "sensor", "objects"}) map.Require(key);
  map.ReadPath("scene", o.scene, "MJCF file with table, arm, hand and scanner");
  o.arranger = kSingle;
  map.Read("arrangement", o.arranger, {kSingle, kScattered, kTouching, kSideBySide, kBox, kPile},
           "arrangement of the objects of a trial; in all but scattered the target is the topmost");
  map.ReadPath(
      "sensor", o.sensor,
      "file of the sensor: a line scanner, a depth camera, a stereo camera, or laser and stereo");
  o.sensor_type = ReadSensorType(o.sensor);
  ReadDetector(map, o);
  map.Read("method", o.method,
           "sets all keys that go beyond the dissertation (`list additions`) at once");
  SetMethod(o.method, o);
  map.ReadPath("reference", o.reference, "published table, printed next to the measured rates");
  o.object_folders = ReadObjectFolders(map);
  map.Read("objects", o.objects, "target objects; each is one row of the table");
  map.Read("trials_per_object", o.trials_per_object, 1, 100000, "number of trials of each object");
  map.Read("max_plans", o.max_plans, 1, 200,
           "maximum number of grasps for which motions are planned before the trial is given up");
  map.ReadScaled("workspace_margin_mm", o.workspace_margin_m, kMm, 50.0, 1000.0,
                 "points further outside the workspace than this are ignored");
  map.ReadScaled("min_tipping_deg", o.min_tipping_rad, kDeg, 0.0, 45.0,
                 "resting poses that tip over at a smaller tilt are excluded");
  map.Read("as_drawn", o.as_drawn, "objects stand as in their models, z up");
  ReadClutterOptions(
      map.Child("clutter",
                "options of the arrangements scattered, touching, side_by_side, box and pile"),
      o.clutter, o.physics.box_wall_m);
  map.Read("color", o.color,
           "the sensors also measure colors, which help to recognize known objects: line scanners "
           "and depth cameras as with `color: true` in their files, stereo cameras from the left "
           "picture");
  ReadPhysicsOptions(map.Child("physics", "physics simulation"), o.physics);
  ReadHandOptions(map.Child("hand", "controller of the hand"), o.firm_from_rad, o.hand);
  // Errors of stereo matching are the same over a window of many samples.
  o.perception.stated_noise = FindSensor(o.sensor_type)->states_noise;
  perception::ReadOptions(map.Child("perception", "perception: from the cloud to objects"),
                          o.perception);
  grasp::ReadGraspOptions(map.Child("grasp", "grasp planning: from objects to grasps"), o);
  const bool any_way = o.grasp.approach == grasp::ApproachKind::kAbove;
  if ((o.take != grasp::kAnywhere || !any_way) && o.detector != kDissertation) {
    map.Fail("grasp", "take and approach need `detector: dissertation`");
  }
  if (o.take != grasp::kAnywhere && !any_way) {
    map.Fail("grasp", "approach: cannot be set, since `take: " + o.take +
                          "` determines the approach direction");
  }
  grasp::ReadPlanningOptions(map.Child("planning", "motion planning: from a grasp to motions"), o,
                             o.obstacles);
  for (const auto& read_keys : KeyReaders()) read_keys(map, o);
  map.Finish();
  return o;
}

void AddOnce(const std::vector<std::string>& names, std::vector<std::string>& list) {
  for (const std::string& name : names) {
    if (std::ranges::find(list, name) == list.end()) list.push_back(name);
  }
}

std::vector<std::string> AllObjects(const Options& options) {
  std::vector<std::string> all = options.objects;
  AddOnce(options.clutter.always, all);
  AddOnce(options.clutter.others, all);
  return all;
}

sim::ObjectModel ObjectModelOf(const Options& options, const std::string& object) {
  const auto in = [&](const fs::path& folder) { return folder / object / (object + ".xml"); };
  for (const auto& folder : options.object_folders) {
    if (fs::is_regular_file(in(folder))) return {object, in(folder)};
  }
  return {object, in(options.object_folders.front())};
}

std::string MissingObject(const std::vector<std::string>& objects, const Options& options) {
  for (const std::string& object : objects) {
    if (fs::is_regular_file(ObjectModelOf(options, object).mjcf)) continue;
    return fmt::format(
        "no object '{0}' (no {0}/{0}.xml in {1}){2}{3}", object,
        fmt::join(options.object_folders | std::views::transform(&fs::path::native), ", "),
        base::Suggestion(object, KnownObjects(options)),
        options.object_folders.size() > 1 ? "" : "; object_folders: [FOLDER] finds your own");
  }
  return "";
}

void CheckObjects(const YamlMap& map, const Options& options) {
  std::set<std::string> seen;
  for (const std::string& object : options.objects) {
    if (!seen.insert(object).second) map.Fail("objects", "names '" + object + "' twice");
  }
  const auto missing = MissingObject(options.objects, options);
  if (!missing.empty()) map.Fail("objects", missing);
  const ClutterOptions& clutter = options.clutter;
  for (const auto& [key, names] :
       {std::pair{"always", &clutter.always}, {"others", &clutter.others}}) {
    const auto missing_other = MissingObject(*names, options);
    if (!missing_other.empty()) map.Inner("clutter").Fail(key, missing_other);
  }
}

bool ModelsPass(const base::YamlMap& map, const Options& options, const experiment::Common& common,
                const std::vector<base::Finding>& warnings) {
  if (common.on_findings) {
    auto findings = FindingsOf(options);
    std::ranges::move(IgnoredKeys(map, options), std::back_inserter(findings));
    findings.insert(findings.end(), warnings.begin(), warnings.end());
    if (!common.on_findings(findings)) return false;
  }
  CheckObjects(map, options);
  CheckArrangement(map, options);
  return true;
}

std::string SceneHash(const Options& options) {
  std::set<fs::path> files;
  const auto add = [&](const std::vector<fs::path>& more) {
    files.insert(more.begin(), more.end());
  };
  CollectModelFiles(options.scene, files);
  for (const std::string& object : AllObjects(options)) {
    const auto mjcf = ObjectModelOf(options, object).mjcf;
    CollectModelFiles(mjcf, files);
    add(sim::SurfaceFiles(mjcf));
  }
  files.insert(options.sensor);
  add(FindSensor(options.sensor_type)->files(options.sensor));
  if (const auto model = grasp::ScoreModelOf(options); !model.empty()) files.insert(model);
  for (const auto& files_of : FileLists()) add(files_of(options));
  // Sorted by name, not by path, so that the same files in another folder have the same hash. Each
  // file counts once, whatever path leads to it.
  std::set<std::pair<std::string, fs::path>> sorted;
  for (const auto& file : files) {
    sorted.emplace(file.filename().string(), fs::weakly_canonical(file));
  }
  std::uint64_t hash = base::Fnv1a("");
  for (const auto& [name, file] : sorted) hash = base::Fnv1a(name + base::ReadFile(file), hash);
  return base::Hex(hash);
}

}  // namespace rangegrasp::trial
