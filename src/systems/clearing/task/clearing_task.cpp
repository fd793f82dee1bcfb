#include <fmt/format.h>

#include <utility>

#include "base/stopwatch.h"
#include "clearing/task/clearing_report.h"
#include "experiment/experiment.h"
#include "sim/world.h"
#include "trial/options.h"
#include "trial/recorder.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::clearing {
namespace {

using experiment::Case;
using experiment::ReplayOptions;
using experiment::Result;
using experiment::Stamp;

// Reads the keys that it does not share with grasping.
void ReadClearingKeys(base::YamlMap& map, ClearingOptions& o) {
  map.Read("runs", o.runs, 1, 100000, "number of arrangements to clear");
  auto keys = map.Child("clearing", "rules from one grasp to the next");
  keys.Read("tries_per_object", o.tries_per_object, 1, 20,
            "number of failed grasps of an object before it is skipped");
  keys.Read("max_grasps", o.max_grasps, 0, 10000,
            "maximum number of grasps of a run; 0: tries_per_object for each object");
  keys.Read("idle_scans", o.idle_scans, 0, 20,
            "number of new scans without a possible grasp before the run is given up");
  keys.Finish();
}

// Each case is an arrangement. Its group is the arrangement's word.
class ClearingExperiment : public trial::SceneTask {
 public:
  ClearingExperiment(trial::Options grasping, const ClearingOptions& options, std::uint64_t seed)
      : cell_(std::move(grasping)), options_(options), seed_(seed) {}

  // The objects take turns at being the target, which is dropped last and is the highest. If a run
  // leaves no record, all "objects" count as not delivered: an upper bound if their number is
  // drawn.
  std::vector<Case> Cases() const override {
    const auto& objects = cell_.options.objects;
    const std::string group = cell_.options.arranger;
    std::vector<Case> cases;
    for (int i = 0; i < options_.runs; ++i) {
      const std::string& target = objects[static_cast<std::size_t>(i) % objects.size()];
      cases.push_back(
          {fmt::format("{}-{:04}", group, i),
           group,
           base::DeriveSeed(base::DeriveSeed(base::DeriveSeed(seed_, "clearing"), group),
                            static_cast<std::uint64_t>(i)),
           {{"object", target}, {"index", i}, {"objects", cell_.arranger->MaxObjects()}}});
    }
    return cases;
  }

  void Hide(const std::filesystem::path& folder) override { cell_.Hide(folder); }

  Result Run(const Case& which) const override { return RunCase(which, {}); }

  // With snapshots, attempt 3 of case pile-0001 gives `pile-0001_03_perceived.png`,
  // `_03_start.png` and `_03_lifted.png`. The run gives `pile-0001_end.png` and
  // `pile-0001_sheet.png`, which shows all pictures.
  Result Replay(const Case& which, const ReplayOptions& options) const override {
    const auto recorder = trial::MakeRecorder(cell_, which.id, options);
    recorder->KeepMoments([](const std::string& moment) {
      return moment == "start" || moment == "lifted" || moment == "end";
    });
    ClearingObserver observer;
    observer.detector = &recorder->detector();
    observer.execution = recorder->Observer();
    if (auto& on_moment = observer.execution.on_moment) {
      // Skips the end of a grasp: it looks like the start of the next one, except that the objects
      // at the delivery place are removed by then.
      on_moment = [then = on_moment](const std::string& moment, sim::World& world) {
        if (moment != "end") then(moment, world);
      };
    }
    observer.on_attempt = [&](int attempt) {
      recorder->SetPrefix(fmt::format("{}_{:02}", which.id, attempt));
    };
    observer.on_end = [&](sim::World& world) {
      recorder->SetPrefix(which.id);
      recorder->Take("end", world);
    };
    const Result result = RunCase(which, observer);
    recorder->Finish();
    return result;
  }

  void AddTo(Stamp& stamp) const override {
    trial::AddModelsTo(cell_.options, stamp);
    trial::FindDetector(cell_.options.detector)->add_to(cell_.options, stamp);
    trial::AddTitles(cell_.options, stamp);
  }

  const trial::Cell& cell() const override { return cell_; }

 private:
  Result RunCase(const Case& which, const ClearingObserver& observer) const {
    const trial::TrialSpec spec = trial::SpecOf(which);
    base::Stopwatch watch;
    trial::Redraws redraws;
    auto arranged = Arrange(which, redraws);
    if (!arranged) return trial::NoArrangement(redraws);
    const double arrange_s = watch.Restart();
    const int max_grasps = options_.max_grasps > 0
                               ? options_.max_grasps
                               : options_.tries_per_object * arranged->world.objects();
    const Clearing clearing =
        ClearTable(cell_, options_, max_grasps, arranged->world, which.seed, observer);
    Result result = ResultOf(clearing, spec.object);
    result.seconds.insert(result.seconds.begin(), {"arrange", arrange_s});
    result.seconds.emplace_back("clearing", watch.Seconds());
    return result;
  }

  trial::Cell cell_;
  ClearingOptions options_;
  std::uint64_t seed_;
};

std::unique_ptr<experiment::Task> Read(base::YamlMap& map, const experiment::Common& common) {
  if (map.Has("trials_per_object")) {
    map.Fail("trials_per_object", "use `runs` in a clearing experiment");
  }
  if (map.Has("views")) {
    map.Fail(
        "views",
        "cannot be used here: clearing takes one scan per grasp, with the experiment's sensor");
  }
  ClearingOptions options;
  ReadClearingKeys(map, options);
  trial::Options grasping = trial::ReadOptions(map, common.seed);
  if (!trial::ModelsPass(map, grasping, common)) return nullptr;
  trial::FindDetector(grasping.detector)->check(map, grasping, common.case_limit_s);
  return std::make_unique<ClearingExperiment>(std::move(grasping), options, common.seed);
}

}  // namespace
}  // namespace rangegrasp::clearing

namespace rangegrasp {

void RegisterClearing() {
  experiment::AddKind(
      {.name = "clearing",
       .description = "Tables are cleared object by object: one case per arrangement. Besides the "
                      "keys below it has all keys of `task: grasping` except `trials_per_object`.",
       .trials_key = "runs",
       .uses_seed = true,
       .success = clearing::kCleared,
       .read = clearing::Read,
       .read_keys =
           [](base::YamlMap& map) {
             clearing::ClearingOptions options;
             clearing::ReadClearingKeys(map, options);
           },
       .report = clearing::ReportOf});
}

}  // namespace rangegrasp
