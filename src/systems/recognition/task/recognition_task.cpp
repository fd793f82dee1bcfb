#include "recognition/task/recognition_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/rng.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "base/words.h"
#include "experiment/report.h"
#include "geometry/mesh_file.h"
#include "mesh/mesh_object.h"
#include "perception/perceive.h"
#include "recognition/recognize.h"
#include "recognition/views/wrist_scanner.h"
#include "sim/bodies.h"
#include "sim/check/check.h"
#include "trial/grasping_task.h"
#include "trial/judge.h"
#include "trial/registry.h"

namespace rangegrasp::recognition {
namespace {

using base::kMm;
using experiment::Case;
using experiment::IntervalText;
using experiment::PercentText;
using nlohmann::ordered_json;

struct TaskOptions {
  trial::Options grasping;
  LibraryOptions library;
  RecognitionOptions recognition;
  bool without_target = false;
};

/// Maximum errors of a pose that counts as correct.
constexpr double kMaxDistance_m = 0.005;
constexpr double kMaxAngle_rad = base::Deg(5.0);

/// Reads the keys that `task: grasping` does not have.
TaskOptions ReadRecognitionKeys(base::YamlMap& map) {
  TaskOptions o;
  auto keys = RecognitionKeys(map, o.recognition);
  keys.Read("without_target", o.without_target,
            "remove the scene's target from the library; it must then stay unknown");
  keys.Finish();
  ReadLibraryOptions(map, o.library);
  return o;
}

/// A find, compared with ground truth, which only the judge reads.
struct JudgedFind {
  const FoundObject* found = nullptr;
  int truth = -1;  ///< the object that most of its samples belong to; -1: the scene
  bool named_right = false;
  PoseDifference off;  ///< if it is named right
  bool near = false;   ///< named right, and within the tolerances
};

/// Symmetries of the objects themselves, independent of the library's models.
using Symmetries = std::map<std::string, Symmetry>;

JudgedFind JudgeFind(const FoundObject& found, const Symmetries& symmetries,
                     const trial::Sensed& sensed, const sim::World& world) {
  JudgedFind judged;
  judged.found = &found;
  judged.truth = trial::MainObject(found.samples, sensed).value_or(-1);
  if (judged.truth < 0) return judged;
  judged.named_right = world.object_name(judged.truth) == found.object;
  if (!judged.named_right) return judged;
  judged.off = Difference(found.X_CB, world.ObjectPose(judged.truth), symmetries.at(found.object));
  judged.near = judged.off.distance_m <= kMaxDistance_m && judged.off.angle_rad <= kMaxAngle_rad;
  return judged;
}

/// How the target was recognized; unknown if no find belongs to it.
std::string OutcomeOf(const std::vector<JudgedFind>& finds, int target) {
  const auto of_target = std::ranges::find(finds, target, &JudgedFind::truth);
  if (of_target == finds.end()) return "unknown";
  if (!of_target->named_right) return "wrong_object";
  return of_target->near ? "found" : "wrong_pose";
}

/// Counts over a row's scenes, and over all finds in them.
struct Row {
  std::string title = {};
  int scenes = 0, found = 0, wrong_object = 0;
  std::map<std::string, int> otherwise = {};
  std::vector<double> distance_mm = {}, angle_deg = {};
  int finds = 0, wrong = 0, others = 0, others_near = 0;
};

void Add(const experiment::Record& record, const nlohmann::json& data, Row& row) {
  ++row.scenes;
  const std::string& outcome = record.result.outcome;
  row.found += outcome == "found";
  row.wrong_object += outcome == "wrong_object";
  if (outcome != "found") ++row.otherwise[outcome];
  if (!data.contains("finds")) return;
  for (const auto& find : data.at("finds")) {
    ++row.finds;
    if (!find.at("named_right").get<bool>()) {
      ++row.wrong;
    } else if (find.at("is_target").get<bool>()) {
      row.distance_mm.push_back(find.at("distance_m").get<double>() * base::kMmPerM);
      row.angle_deg.push_back(find.at("angle_rad").get<double>() / base::kDeg);
    } else {
      ++row.others;
      row.others_near += find.at("near").get<bool>();
    }
  }
}

std::string TimesNote(const std::vector<experiment::Record>& records) {
  auto times = experiment::StageTimes(records);
  std::ranges::sort(times, {}, &experiment::StageTime::stage);
  std::string text = "median seconds of a scene:";
  for (const auto& one : times) text += fmt::format(" {} {:.2f}", one.stage, one.median_s);
  return text;
}

experiment::Grid TableOf(const std::vector<Row>& rows) {
  const auto median_of = [](std::vector<double> Row::*values) {
    return [values](const Row& row) {
      const auto& all = row.*values;
      return all.empty() ? std::nullopt : std::optional(base::MedianOf(all));
    };
  };
  const std::vector<experiment::Column<Row>> columns = {
      {"object", "", &Row::title, experiment::kLeft},
      {"scenes", "", &Row::scenes},
      {"found %", "", [](const Row& row) { return PercentText(row.found, row.scenes, 1); }},
      {"95 %", "", [](const Row& row) { return IntervalText(row.found, row.scenes); }},
      {"wrong object", "", &Row::wrong_object},
      {"off mm (median)", ".1f", median_of(&Row::distance_mm)},
      {"off deg (median)", ".1f", median_of(&Row::angle_deg)},
      {"otherwise", "", [](const Row& row) { return experiment::CountsText(row.otherwise); },
       experiment::kLeft}};
  auto grid = GridOf(columns, rows);
  grid.total = true;
  return grid;
}

/// One row per object: how often it was found in its true pose, and the other outcomes.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records) {
  std::vector<Row> rows;
  Row all{.title = "All"};
  for (const std::string& object : experiment::GroupsOf(records)) {
    rows.push_back({.title = experiment::TitleOf(stamp, object)});
    for (const auto& record : records) {
      if (record.which.group != object) continue;
      const auto data = nlohmann::json::parse(record.result.data);
      Add(record, data, rows.back());
      Add(record, data, all);
    }
  }
  rows.push_back(all);
  experiment::Report report;
  report.csv = TableOf(rows);
  report.sections.push_back({"Known objects: the scene's target", report.csv});
  report.notes.push_back(
      fmt::format("of {} objects recognized in all scenes, {} were identified as the wrong object "
                  "({} %, 95 %: {})",
                  all.finds, all.wrong, PercentText(all.wrong, all.finds, 1),
                  IntervalText(all.wrong, all.finds)));
  if (all.others > 0) {
    report.notes.push_back(
        fmt::format("of {} other objects recognized correctly, {} had the correct pose ({} %)",
                    all.others, all.others_near, PercentText(all.others_near, all.others, 1)));
  }
  report.notes.push_back(TimesNote(records));
  return report;
}

/// The file of an object in a library's folder.
std::filesystem::path FileIn(const std::filesystem::path& folder, const std::string& object) {
  for (const auto& file : {folder / object / (object + ".xml"), folder / (object + ".stl")}) {
    if (std::filesystem::is_regular_file(file)) return file;
  }
  throw base::InputError(fmt::format("{}: no model of '{}' (neither {}/{}.xml nor {}.stl)",
                                     folder.string(), object, object, object, object));
}

/// The file, and all next to it if it is an object's own folder: its meshes. In order of names.
std::set<std::filesystem::path> FilesOf(const std::filesystem::path& file) {
  if (file.extension() != ".xml") return {file};
  std::set<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(file.parent_path())) {
    if (entry.is_regular_file()) files.insert(entry.path());
  }
  return files;
}

/// The surface is sampled every few millimetres: one in another unit would take all memory.
void RefuseSize(const std::filesystem::path& file, const geometry::TriangleMesh& mesh) {
  const double length_m = std::max(0.0, geometry::BoundsOf(mesh.vertices).sizes().maxCoeff());
  if (length_m >= check::kMinSize_m && length_m <= check::kMaxSize_m) return;
  std::string cure = "write a scale in each <mesh>, e.g. scale=\"0.001 0.001 0.001\"";
  if (file.extension() != ".xml") {
    const auto unit = objects::GuessUnit(length_m);
    cure = fmt::format("scale it, or make an object of it with `rangegrasp add-object {} {}`",
                       file.string(),
                       unit ? fmt::format("--unit {}", base::Word(*unit)) : "--size-mm LENGTH");
  }
  throw base::InputError(
      fmt::format("{}: is {:.3g} m long, but known objects are {} to {} m long; meshes are in "
                  "metres: {}",
                  file.string(), length_m, check::kMinSize_m, check::kMaxSize_m, cure));
}

KnownObject KnownFrom(const sim::ObjectModel& model, const LibraryOptions& library = {}) {
  const auto file = library.folder.empty() ? model.mjcf : FileIn(library.folder, model.name);
  auto surface = file.extension() == ".xml" ? sim::ObjectSurface({model.name, file})
                                            : geometry::ColoredMesh{geometry::ReadMesh(file), {}};
  RefuseSize(file, surface.mesh);
  if (library.distortion_m > 0.0) {
    base::Rng rng(base::DeriveSeed(base::DeriveSeed(library.seed, "distortion"), model.name));
    surface = Distorted(surface, library.distortion_m, rng);
  }
  std::string title = model.mjcf.extension() == ".xml" ? sim::ObjectTitle(model) : model.name;
  return MakeKnownObject(model.name, std::move(title), std::move(surface.mesh),
                         std::move(surface.colors));
}

Symmetries SymmetriesOf(const trial::Options& options) {
  Symmetries symmetries;
  for (const std::string& object : options.objects) {
    symmetries.emplace(object, KnownFrom(trial::ObjectModelOf(options, object)).symmetry);
  }
  return symmetries;
}

ordered_json JsonOf(const std::vector<JudgedFind>& judged, const sim::World& world, int target) {
  ordered_json finds = ordered_json::array();
  for (const JudgedFind& find : judged) {
    finds.push_back({{"object", find.found->object},
                     {"truth", find.truth < 0 ? "" : world.object_name(find.truth)},
                     {"is_target", find.truth == target},
                     {"named_right", find.named_right},
                     {"near", find.near},
                     {"distance_m", find.off.distance_m},
                     {"angle_rad", find.off.angle_rad},
                     {"alternatives", find.found->alternatives_CB.size()},
                     {"score", find.found->score},
                     {"color", find.found->color},
                     {"share_seen", find.found->share_seen},
                     {"violations", find.found->violations},
                     {"rms_m", find.found->rms_m},
                     {"samples", find.found->samples.size()}});
  }
  return finds;
}

class Recognition : public trial::SceneTask {
 public:
  Recognition(const TaskOptions& options, const experiment::Common& common)
      : options_(options),
        cell_(options.grasping),
        library_(LibraryOf(options.grasping, options.library)),
        symmetries_(SymmetriesOf(options.grasping)),
        seed_(common.seed) {}

  std::vector<Case> Cases() const override { return trial::TrialsOf(cell_.options, seed_); }

  experiment::Result Run(const Case& which) const override {
    const trial::TrialSpec spec = trial::SpecOf(which);
    base::Stopwatch watch;
    trial::Redraws redraws;
    auto arranged = Arrange(which, redraws);
    if (!arranged) return trial::NoArrangement(redraws);
    experiment::Result result;
    result.seconds.emplace_back("arrange", watch.Restart());
    const Recognized seen = LookUntilSure(arranged->world, spec, result);
    const sim::World& world = arranged->world;
    const int target = arranged->target;
    std::vector<JudgedFind> judged;
    for (const FoundObject& one : seen.found) {
      judged.push_back(JudgeFind(one, symmetries_, seen.sensed, world));
    }
    result.outcome = OutcomeOf(judged, target);
    result.stage = "recognize";
    const ordered_json data = {{"pose_class", arranged->pose_class},
                               {"scene_objects", world.objects()},
                               {"objects", seen.scene.objects.size()},
                               {"views", seen.sensed.observation.views.size()},
                               {"finds", JsonOf(judged, world, target)}};
    result.data = data.dump();
    return result;
  }

  void AddTo(experiment::Stamp& stamp) const override {
    trial::AddModelsTo(cell_.options, stamp);
    trial::AddTitles(cell_.options, stamp);
    AddLibraryTo(stamp, options_.library, cell_.options.objects);
  }

  const trial::Cell& cell() const override { return cell_; }

 private:
  /// Results from the views so far.
  struct Recognized {
    trial::Sensed sensed;
    perception::Scene scene;
    std::vector<FoundObject> found;
  };

  /// Looks from the fixed sensor, then from the wrist while an object is open (OpenObjects).
  Recognized LookUntilSure(sim::World& world, const trial::TrialSpec& spec,
                           experiment::Result& result) const {
    base::Stopwatch watch;
    Recognized seen;
    seen.sensed = trial::Look(cell_, world, spec.seed);
    const int views = trial::Of<views::WristViewOptions>(cell_.options, views::kWristViews).views;
    result.seconds.emplace_back("scan", watch.Seconds());
    RecognizeAll(spec, seen, result);
    if (views == 1) return seen;
    views::WristScanner wrist(cell_.options, cell_.robot, spec.seed);
    Eigen::VectorXd q = cell_.robot.home;
    for (int view = 1; view < views; ++view) {
      watch.Restart();
      const bool looked = LookAtFirstOpen(wrist, world, q, seen);
      experiment::AddSeconds("scan", watch.Seconds(), result.seconds);
      if (!looked) break;
      RecognizeAll(spec, seen, result);
    }
    return seen;
  }

  void RecognizeAll(const trial::TrialSpec& spec, Recognized& seen,
                    experiment::Result& result) const {
    base::Stopwatch watch;
    base::Rng perceive = trial::StageStream(spec.seed, "perceive");
    seen.scene =
        perception::Perceive(seen.sensed.observation, options_.grasping.perception, perceive,
                             trial::WorkspaceOf(cell_.robot, options_.grasping.workspace_margin_m));
    experiment::AddSeconds("perceive", watch.Restart(), result.seconds);
    RecognitionOptions recognition = options_.recognition;
    if (options_.without_target) recognition.left_out = spec.object;
    seen.found =
        Recognize(seen.sensed.observation, seen.scene, library_, recognition, SureOnes(seen.found));
    experiment::AddSeconds("recognize", watch.Seconds(), result.seconds);
  }

  /// @return whether a view was added: of the topmost ambiguous object that is worth a look
  bool LookAtFirstOpen(views::WristScanner& wrist, sim::World& world, Eigen::VectorXd& q,
                       Recognized& seen) const {
    const auto open = OpenObjects(seen.scene, seen.found, options_.recognition);
    for (const std::size_t object : open) {
      const auto region_W =
          wrist.RegionAbout(seen.scene.objects[object].center_C, seen.sensed.observation);
      const auto look = wrist.AddBestView(region_W, world, q, seen.sensed);
      if (look) return look->arrived;
    }
    return false;
  }

  TaskOptions options_;
  trial::Cell cell_;
  Library library_;
  Symmetries symmetries_;
  std::uint64_t seed_;
};

std::unique_ptr<experiment::Task> Read(base::YamlMap& map, const experiment::Common& common) {
  TaskOptions options = ReadRecognitionKeys(map);
  options.grasping = trial::ReadOptions(map, common.seed);
  const auto wrist = WristViewsOf(map, options.grasping);
  if (!ModelsPass(map, options.grasping, wrist.views > 1, common)) return nullptr;
  trial::RequireOwnDetector(map, options.grasping);
  options.library.seed = common.seed;
  return std::make_unique<Recognition>(options, common);
}

}  // namespace

base::YamlMap RecognitionKeys(base::YamlMap& map, RecognitionOptions& options) {
  auto keys = map.Child("recognition",
                        "recognition: from perceived objects to known objects and their poses");
  keys.ReadScaled("tolerance_mm", options.tolerance_m, kMm, 0.5, 20.0,
                  "maximum distance of explained samples from a model's surface");
  return keys;
}

void ReadLibraryOptions(base::YamlMap& map, LibraryOptions& options) {
  auto keys = map.Child("library", "models of the known objects");
  keys.ReadPath("folder", options.folder,
                "folder with NAME/NAME.xml of each object or NAME.stl, in metres, in the frame of "
                "its model; default: the simulator's own meshes, which are exact");
  keys.ReadScaled("distortion_mm", options.distortion_m, kMm, 0.0, 20.0,
                  "smooth random displacement of the meshes' surfaces, root mean square");
  keys.Finish();
}

void AddLibraryTo(experiment::Stamp& stamp, const LibraryOptions& library,
                  std::span<const std::string> objects) {
  if (library.folder.empty()) return;
  std::uint64_t hash = base::Fnv1a("");
  for (const std::string& object : objects) {
    for (const auto& file : FilesOf(FileIn(library.folder, object))) {
      hash = base::Fnv1a(object + base::ReadFile(file), hash);
    }
  }
  stamp.identity["library_hash"] = base::Hex(hash);
}

Library LibraryOf(const trial::Options& options, const LibraryOptions& library) {
  std::vector<KnownObject> known;
  for (const std::string& object : options.objects) {
    known.push_back(KnownFrom(trial::ObjectModelOf(options, object), library));
  }
  return Library(std::move(known));
}

views::WristViewOptions WristViewsOf(const base::YamlMap& map, const trial::Options& options) {
  if (options.take != grasp::kAnywhere) map.Fail("grasp", "take: only for `task: grasping`");
  const auto wrist = trial::Of<views::WristViewOptions>(options, views::kWristViews);
  if (wrist.until_probability < 1.0) {
    map.Fail("look", "until_probability: only for `task: grasping`");
  }
  return wrist;
}

bool ModelsPass(const base::YamlMap& map, const trial::Options& options, bool wrist,
                const experiment::Common& common) {
  const bool laser =
      wrist || !trial::FindSensor(options.sensor_type)->laser(options.sensor).empty();
  std::vector<base::Finding> warnings;
  if (!laser) {
    warnings.push_back(
        {.error = false,
         .where = common.file.string(),
         .element = "sensor",
         .what = "a stereo camera alone found none of the known objects so far: its noise is "
                 "larger than the 3 mm within which a model explains a sample",
         .cure = "use a sensor with a laser, e.g. models/sensors/line_scanner.yaml"});
  }
  return trial::ModelsPass(map, options, common, warnings);
}

Library LoadLibrary(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) {
    throw base::InputError(folder.string() +
                           ": no folder (it must contain NAME/NAME.xml or NAME.stl for every "
                           "known object)");
  }
  std::map<std::string, std::filesystem::path> files;  // by name: same on every file system
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const bool mesh = entry.is_regular_file() && entry.path().extension() == ".stl";
    const std::string name = (mesh ? entry.path().stem() : entry.path().filename()).string();
    if (mesh || std::filesystem::is_regular_file(entry.path() / (name + ".xml"))) {
      files.try_emplace(name, FileIn(folder, name));
    }
  }
  if (files.empty()) {
    throw base::InputError(folder.string() +
                           ": contains no known object (NAME/NAME.xml or NAME.stl)");
  }
  std::vector<KnownObject> known;
  for (const auto& [name, file] : files) known.push_back(KnownFrom({name, file}));
  return Library(std::move(known));
}

const experiment::TaskKind& RecognitionTask() {
  static const experiment::TaskKind kind{
      .name = "recognition",
      .description =
          "Known objects (chapter 7) and their poses are recognized in a scan. Besides the keys "
          "below it has all keys of `task: grasping`.",
      .trials_key = "trials_per_object",
      .uses_seed = true,
      .success = "found",
      .read = Read,
      .read_keys = [](base::YamlMap& map) { ReadRecognitionKeys(map); },
      .report = ReportOf};
  return kind;
}

}  // namespace rangegrasp::recognition
