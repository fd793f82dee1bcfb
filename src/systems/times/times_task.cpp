#include "times/times_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "base/quantile.h"
#include "base/stopwatch.h"
#include "grasp/grasp.h"
#include "perception/perceive.h"
#include "sim/info.h"
#include "times/times_options.h"
#include "times/times_report.h"
#include "trial/attempt.h"
#include "trial/objects.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::times {
namespace {

using experiment::Case;
using nlohmann::ordered_json;
using Seconds = std::vector<std::pair<std::string, double>>;

// Of one perception and its grasps.
struct Run {
  perception::Scene scene;
  std::size_t grasps = 0;
  Seconds seconds;
};

// Grasps for every object, as table 5.1 has them; a trial plans those of the topmost alone.
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

// Each stage's median.
Seconds MedianOf(const std::vector<Run>& runs) {
  Seconds medians;
  for (std::size_t i = 0; i < runs.front().seconds.size(); ++i) {
    std::vector<double> all;
    for (const Run& run : runs) all.push_back(run.seconds[i].second);
    medians.emplace_back(runs.front().seconds[i].first, base::MedianOf(all));
  }
  return medians;
}

class TimesExperiment : public experiment::Task {
 public:
  TimesExperiment(const Options& options, const experiment::Common& common)
      : options_(options), cell_(options.grasping), seed_(common.seed) {}

  std::vector<Case> Cases() const override {
    std::vector<Case> cases;
    for (int scene = 0; scene < Scenes(); ++scene) {
      for (const std::string& word : Words()) {
        const ordered_json params = {{"scene", scene}, {"method", word}};
        // One seed a scene: all methods see the same scan.
        cases.push_back(
            {fmt::format("scene{}-{}", scene + 1, word), word,
             base::DeriveSeed(base::DeriveSeed(seed_, "times"), static_cast<std::uint64_t>(scene)),
             params.dump()});
      }
    }
    return cases;
  }

  experiment::Result Run(const Case& which) const override {
    const auto params = nlohmann::json::parse(which.params);
    const int scene = params.at("scene");
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
    const trial::Options own = OptionsOf(params.at("method"));
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

  experiment::Result Replay(const Case& which, const experiment::ReplayOptions&) const override {
    return Run(which);
  }

  void AddTo(experiment::Stamp& stamp) const override {
    stamp.identity["scene_hash"] = trial::SceneHash(cell_.options);
    stamp.identity["mujoco"] = sim::EngineVersion();
    stamp.data[kTimed] = base::Word(options_.timed);
    if (!cell_.options.reference.empty()) {
      stamp.data[kReference] = base::ReadFile(cell_.options.reference);
    }
  }

 private:
  bool Stages() const { return options_.timed == Timed::kStages; }
  int Scenes() const {
    return Stages() ? options_.scenes
                    : std::min(options_.scenes, static_cast<int>(options_.published.size()));
  }
  std::vector<std::string> Words() const {
    std::vector<std::string> words;
    if (Stages()) {
      for (const auto method : options_.methods) words.emplace_back(base::Word(method));
    } else {
      for (const auto method : options_.segmentations) words.emplace_back(base::Word(method));
    }
    return words;
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
  const Options options = ReadOptions(map);
  trial::CheckObjects(map, options.grasping);
  trial::RequireOwnDetector(map, options.grasping);
  return std::make_unique<TimesExperiment>(options, common);
}

}  // namespace

const experiment::TaskKind& TimesTask() {
  static const experiment::TaskKind kind{
      .name = "times",
      .description =
          "Computing times of perception and grasps on scans of published sizes. Beside the keys "
          "below it has all of `task: grasping` but `trials_per_object`.",
      .trials_key = "scenes",
      .uses_seed = true,
      .success = {},
      .read = Read,
      .check = [](base::YamlMap& map) { return trial::CheckModels(ReadOptions(map).grasping); },
      .read_keys =
          [](base::YamlMap& map) {
            Options options;
            ReadTimesKeys(map, options);
          },
      .report = ReportOf};
  return kind;
}

}  // namespace rangegrasp::times
