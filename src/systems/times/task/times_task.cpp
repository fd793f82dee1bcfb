#include "times/task/times_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "experiment/experiment.h"
#include "grasp/detector.h"
#include "grasp/grasp.h"
#include "perception/perceive.h"
#include "sensing/line_scanner.h"
#include "sim/world.h"
#include "times/task/times_report.h"
#include "trial/options.h"
#include "trial/registry.h"

namespace rangegrasp::times {
namespace {

using Seconds = std::vector<std::pair<std::string, double>>;
using experiment::Case;
using experiment::Result;
using experiment::Stamp;
using nlohmann::ordered_json;

// Each rescan is denser than required by this factor; excess points are removed.
constexpr double kSpare = 1.02;
constexpr int kScans = 6;

enum class Part { kObject, kTable, kElse };

std::vector<Part> PartsOf(const trial::Cell& cell, const sim::World& world,
                          const sensing::Scan& scan) {
  const geometry::Plane table_W = cell.TablePlane();
  const double clearance_m = cell.options.perception.preprocess.table_clearance_m;
  const auto workspace = trial::WorkspaceOf(cell.robot, cell.options.workspace_margin_m);
  std::vector<Part> parts;
  for (std::size_t i = 0; i < scan.view.image.points_C.size(); ++i) {
    const Eigen::Vector3d& p_W = scan.view.image.points_C[i];
    const auto label = static_cast<int>(scan.truth.label[i]);
    const double height_m = table_W.Distance(p_W);
    Part part = Part::kElse;
    if (p_W.allFinite() && workspace.Contains(p_W)) {
      if (label > 0 && label <= world.objects() && height_m > clearance_m) part = Part::kObject;
      if (label == 0 && std::abs(height_m) < clearance_m) part = Part::kTable;
    }
    parts.push_back(part);
  }
  return parts;
}

int Count(const std::vector<Part>& parts, Part part) {
  return static_cast<int>(std::ranges::count(parts, part));
}

// Keeps `wanted` points of one part, evenly spaced in their order.
void Keep(const std::vector<Part>& parts, Part part, int wanted, geometry::Points& points_W) {
  const std::int64_t have = Count(parts, part);
  std::int64_t seen = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i] != part) continue;
    const bool kept = (seen + 1) * wanted / have > seen * wanted / have;
    ++seen;
    if (!kept) points_W[i].setConstant(std::numeric_limits<double>::quiet_NaN());
  }
}

struct Options {
  trial::Options grasping;
  Timed timed = Timed::kStages;
  int scenes = 10;              // for `segmentations`: at most the published number
  ScanSize size{22377, 19646};  // for `stages`: the published scene's (fig. 5.5)
  int repeats = 5;              // of each scene; the median is used
  std::vector<trial::MethodKind> methods = {trial::MethodKind::kPublished,
                                            trial::MethodKind::kImproved};
  std::vector<perception::SegmentMethod> segmentations = {perception::SegmentMethod::kRegionGrowing,
                                                          perception::SegmentMethod::kMesh};
  std::vector<ScanSize> published;  // for `segmentations`: the reference's scenes
};

constexpr int kMinPoints = 100;
constexpr int kMaxPoints = 10'000'000;

// Reads the keys except those that it shares with grasping.
Options ReadTimesKeys(base::YamlMap& map) {
  Options o;
  map.Read("timed", o.timed,
           "the stages of table 5.1, or the segmentations of figures 5.8 and 5.9");
  map.Read("scenes", o.scenes, 1, 10000,
           "number of arrangements; segmentations: at most those of the reference");
  map.Read("object_points", o.size.object_points, kMinPoints, kMaxPoints,
           "number of object points in a scan; segmentations: as in the reference");
  map.Read("table_points", o.size.table_points, kMinPoints, kMaxPoints,
           "number of table points in a scan; segmentations: as in the reference");
  map.Read("repeats", o.repeats, 1, 1000, "number of repeated measurements; the median is used");
  map.Read("methods", o.methods, "methods whose stages are timed");
  map.Read("segmentations", o.segmentations, "segmentations to time");
  return o;
}

// Reads all keys, to the end of the map. @throws base::InputError also for an invalid reference.
Options ReadOptions(base::YamlMap& map, std::uint64_t seed) {
  if (map.Has("trials_per_object")) {
    map.Fail("trials_per_object", "use `scenes` in `task: times`");
  }
  Options options = ReadTimesKeys(map);
  options.grasping = trial::ReadOptions(map, seed);
  if (options.grasping.take != grasp::kAnywhere) {
    map.Fail("grasp", "take: only for `task: grasping`");
  }
  if (options.timed != Timed::kSegmentations) return options;
  if (options.grasping.reference.empty()) {
    map.Fail("reference",
             "the published scenes' sizes are needed (columns object_points, table_points)");
  }
  const auto csv = base::CsvTable::Read(options.grasping.reference);
  const auto points = [&](std::size_t row, const char* column) {
    const std::size_t at = csv.Column(column);
    const double number = csv.Number(row, at);
    if (number >= 1.0 && number <= kMaxPoints) return static_cast<int>(number);
    csv.Fail(row, at, fmt::format("must be a number of points from 1 to {}", kMaxPoints));
  };
  for (std::size_t row = 0; row < csv.rows(); ++row) {
    options.published.push_back({points(row, "object_points"), points(row, "table_points")});
  }
  return options;
}

// Result of one perception, with the number of its grasps.
struct Run {
  perception::Scene scene;
  std::size_t grasps = 0;
  Seconds seconds;
};

// Plans grasps for every object, as in table 5.1; a trial plans only those of the topmost one.
Run RunOnce(const trial::Cell& cell, const trial::Options& options,
            const geometry::Observation& observation, std::uint64_t seed, bool grasps) {
  base::Rng rng = trial::StageStream(seed, "perceive");
  Run run;
  run.scene = perception::Perceive(observation, options.perception, rng);
  run.seconds = run.scene.seconds;
  if (!grasps) return run;
  base::Stopwatch watch;
  const Eigen::Vector3d arm_W = cell.robot.links().front().X_PB.translation();
  for (std::size_t i = 0; i < run.scene.objects.size(); ++i) {
    run.grasps += grasp::PlanGrasps(run.scene, i, cell.robot.hand(), arm_W, options.grasp).size();
  }
  run.seconds.emplace_back("grasp", watch.Seconds());
  return run;
}

// The median of each stage.
Seconds MedianOf(const std::vector<Run>& runs) {
  Seconds medians;
  for (std::size_t i = 0; i < runs.front().seconds.size(); ++i) {
    std::vector<double> all;
    for (const Run& run : runs) all.push_back(run.seconds[i].second);
    medians.emplace_back(runs.front().seconds[i].first, base::MedianOf(all));
  }
  return medians;
}

template <typename Method>
std::vector<std::string> WordsOfAll(const std::vector<Method>& methods) {
  std::vector<std::string> words;
  for (const Method method : methods) words.emplace_back(base::Word(method));
  return words;
}

// A case is a scene and a method; the group is the method.
class TimesExperiment : public experiment::Task {
 public:
  TimesExperiment(const Options& options, const experiment::Common& common)
      : options_(options), cell_(options.grasping), seed_(common.seed) {}

  std::vector<Case> Cases() const override {
    std::vector<Case> cases;
    for (int scene = 0; scene < Scenes(); ++scene) {
      for (const std::string& word : Words()) {
        // One seed per scene: all methods see the same scan.
        cases.push_back(
            {fmt::format("scene{}-{}", scene + 1, word),
             word,
             base::DeriveSeed(base::DeriveSeed(seed_, "times"), static_cast<std::uint64_t>(scene)),
             {{"scene", scene}, {"method", word}}});
      }
    }
    return cases;
  }

  Result Run(const Case& which) const override {
    const int scene = which.params.Int("scene");
    base::Rng arrange = trial::StageStream(which.seed, "arrange");
    trial::Redraws redraws;
    const auto& objects = cell_.options.objects;
    const auto arranged = cell_.arranger->Arrange(
        objects[static_cast<std::size_t>(scene) % objects.size()], arrange, redraws);
    if (!arranged) return trial::NoArrangement(redraws);
    const ScanSize size =
        Stages() ? options_.size : options_.published[static_cast<std::size_t>(scene)];
    const auto scan =
        SizedScan(cell_, arranged->world, size, trial::StageStream(which.seed, "scan"));
    const trial::Options own = OptionsOf(which.params.Text("method"));
    std::vector<times::Run> runs;
    for (int i = 0; i < options_.repeats; ++i) {
      runs.push_back(RunOnce(cell_, own, scan, which.seed, Stages()));
    }
    const ordered_json data = {{"scene", scene + 1},
                               {"objects", arranged->world.objects()},
                               {"object_points", size.object_points},
                               {"table_points", size.table_points},
                               {"kept_points", runs.front().scene.cloud.size()},
                               {"segments", runs.front().scene.segments.size()},
                               {"perceived", runs.front().scene.objects.size()},
                               {"grasps", runs.front().grasps}};
    return {"timed", "perceive", "", data.dump(), MedianOf(runs)};
  }

  void AddTo(Stamp& stamp) const override {
    trial::AddModelsTo(cell_.options, stamp);
    stamp.data[kTimed] = base::Word(options_.timed);
    if (!cell_.options.reference.empty()) {
      stamp.data[experiment::kReferenceKey] = experiment::PublishedText(cell_.options.reference);
    }
  }

 private:
  bool Stages() const { return options_.timed == Timed::kStages; }
  int Scenes() const {
    return Stages() ? options_.scenes
                    : std::min(options_.scenes, static_cast<int>(options_.published.size()));
  }
  std::vector<std::string> Words() const {
    return Stages() ? WordsOfAll(options_.methods) : WordsOfAll(options_.segmentations);
  }
  trial::Options OptionsOf(const std::string& word) const {
    trial::Options own = cell_.options;
    if (Stages()) {
      trial::SetMethod(base::FromWord<trial::MethodKind>(word, "method"), own);
    } else {
      own.perception.segment.method =
          base::FromWord<perception::SegmentMethod>(word, "segmentation");
    }
    return own;
  }

  Options options_;
  trial::Cell cell_;
  std::uint64_t seed_;
};

std::unique_ptr<experiment::Task> Read(base::YamlMap& map, const experiment::Common& common) {
  const Options options = ReadOptions(map, common.seed);
  if (!trial::ModelsPass(map, options.grasping, common)) return nullptr;
  trial::RequireOwnDetector(map, options.grasping);
  return std::make_unique<TimesExperiment>(options, common);
}

}  // namespace

geometry::Observation SizedScan(const trial::Cell& cell, const sim::World& world,
                                const ScanSize& size, base::Rng rng) {
  sensing::LineScannerOptions scanner = cell.scanner;
  for (int i = 0; i < kScans; ++i) {
    base::Rng same = rng;
    sensing::Scan scan =
        sensing::ScanScene(world.VisualMeshes(), cell.robot.X_WScanner, scanner, same);
    const auto parts = PartsOf(cell, world, scan);
    const int objects = Count(parts, Part::kObject);
    const int table = Count(parts, Part::kTable);
    if (objects == 0 || table == 0) break;
    if (objects < size.object_points || table < size.table_points) {
      const double denser =
          std::sqrt(kSpare * std::max(static_cast<double>(size.object_points) / objects,
                                      static_cast<double>(size.table_points) / table));
      scanner.samples = static_cast<int>(std::ceil(scanner.samples * denser));
      scanner.profiles = static_cast<int>(std::ceil(scanner.profiles * denser));
      continue;
    }
    auto& points_W = scan.view.image.points_C;
    Keep(parts, Part::kObject, size.object_points, points_W);
    Keep(parts, Part::kTable, size.table_points, points_W);
    Keep(parts, Part::kElse, 0, points_W);
    geometry::Observation observation;
    observation.views.push_back(std::move(scan.view));
    return observation;
  }
  throw base::InputError(fmt::format("no scan with {} object points and {} table points",
                                     size.object_points, size.table_points));
}

}  // namespace rangegrasp::times

namespace rangegrasp {

void RegisterTimes() {
  experiment::AddKind(
      {.name = "times",
       .description =
           "Computing times of perception and grasp planning on scans of published sizes. Besides "
           "the keys below it has all keys of `task: grasping` except `trials_per_object`.",
       .trials_key = "scenes",
       .uses_seed = true,
       .success = {},
       .read = times::Read,
       .read_keys = [](base::YamlMap& map) { times::ReadTimesKeys(map); },
       .report = times::ReportOf});
}

}  // namespace rangegrasp
