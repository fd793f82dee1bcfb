#include "clearing/clearing_task.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/stopwatch.h"
#include "base/words.h"
#include "clearing/clearing_record.h"
#include "clearing/clearing_replay.h"
#include "clearing/clearing_report.h"
#include "sim/info.h"
#include "trial/objects.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::clearing {
namespace {

using experiment::Case;

class ClearingExperiment : public experiment::Task {
 public:
  ClearingExperiment(const Options& options, const experiment::Common& common)
      : cell_(options.grasping),
        options_(options.clearing),
        max_grasps_(options.MaxGrasps()),
        seed_(common.seed) {}

  // The object that is dropped last, and is highest, goes round.
  std::vector<Case> Cases() const override {
    const auto& objects = cell_.options.objects;
    const std::string group = cell_.options.arranger;
    std::vector<Case> cases;
    for (int i = 0; i < options_.runs; ++i) {
      const std::string& target = objects[static_cast<std::size_t>(i) % objects.size()];
      const nlohmann::ordered_json params = {
          {"object", target}, {"index", i}, {"objects", ObjectsOfARun()}};
      cases.push_back(
          {fmt::format("{}-{:04}", group, i), group,
           base::DeriveSeed(base::DeriveSeed(base::DeriveSeed(seed_, "clearing"), group),
                            static_cast<std::uint64_t>(i)),
           params.dump()});
    }
    return cases;
  }

  void Hide(const std::filesystem::path& folder) override { cell_.Hide(folder); }

  experiment::Result Run(const Case& which) const override { return RunCase(which, {}); }

  experiment::Result Replay(const Case& which,
                            const experiment::ReplayOptions& options) const override {
    return ReplayClearing(cell_, which.id, options, [&](const ClearingObserver& observer) {
      return RunCase(which, observer);
    });
  }

  void AddTo(experiment::Stamp& stamp) const override {
    stamp.identity["scene_hash"] = trial::SceneHash(cell_.options);
    trial::AddDetectorTo(cell_.options, stamp);
    stamp.identity["mujoco"] = sim::EngineVersion();
    trial::AddTitles(cell_.options, stamp);
  }

 private:
  // Of a run that leaves no record all of them count as not delivered.
  std::size_t ObjectsOfARun() const {
    const bool alone = cell_.options.arranger == trial::kSingle;
    return alone ? 1 : cell_.options.objects.size();
  }

  experiment::Result RunCase(const Case& which, const ClearingObserver& observer) const {
    const auto params = nlohmann::json::parse(which.params);
    const trial::TrialSpec spec{params.at("object"), params.at("index"), which.seed};
    base::Stopwatch watch;
    trial::Redraws redraws;
    auto arranged = trial::ArrangeTrial(cell_, spec, redraws);
    if (!arranged) return trial::NoArrangement(redraws);
    const double arrange_s = watch.Restart();
    const Clearing clearing =
        ClearTable(cell_, options_, max_grasps_, arranged->world, which.seed, observer);
    experiment::Result result = ResultOf(clearing, spec.object);
    result.seconds.insert(result.seconds.begin(), {"arrange", arrange_s});
    result.seconds.emplace_back("clearing", watch.Seconds());
    return result;
  }

  trial::Cell cell_;
  ClearingOptions options_;
  int max_grasps_;
  std::uint64_t seed_;
};

std::unique_ptr<experiment::Task> Read(base::YamlMap& map, const experiment::Common& common) {
  const Options options = ReadOptions(map);
  trial::CheckObjects(map, options.grasping);
  trial::CheckDetector(map, options.grasping, common.case_limit_s);
  return std::make_unique<ClearingExperiment>(options, common);
}

}  // namespace

const experiment::TaskKind& ClearingTask() {
  static const experiment::TaskKind kind{
      .name = "clearing",
      .description =
          "Tables that are cleared object by object: one case "
          "an arrangement. Beside the keys below it "
          "has all of `task: grasping` but `trials_per_object`.",
      .trials_key = "runs",
      .uses_seed = true,
      .success = kCleared,
      .read = Read,
      .check = [](base::YamlMap& map) { return trial::CheckModels(ReadOptions(map).grasping); },
      .read_keys =
          [](base::YamlMap& map) {
            ClearingOptions options;
            ReadClearingKeys(map, options);
          },
      .report = ReportOf};
  return kind;
}

}  // namespace rangegrasp::clearing
