#include "recognition/bring/bring_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/stopwatch.h"
#include "base/words.h"
#include "recognition/bring/bring_report.h"
#include "recognition/task/known_objects.h"
#include "sim/info.h"
#include "trial/hand_over.h"
#include "trial/objects.h"
#include "trial/recorder.h"
#include "trial/registry.h"
#include "trial/table.h"
#include "trial/trial.h"

namespace rangegrasp::bring {
namespace {

using experiment::Case;

std::vector<sim::ObjectModel> ModelsOf(const Options& options) {
  std::vector<sim::ObjectModel> models;
  for (const std::string& object : options.bring.known) {
    models.push_back(trial::ObjectModelOf(options.grasping, object));
  }
  return models;
}

/// The number of an object in the world; nullopt: it is not there.
std::optional<int> NumberOf(const std::string& object, const sim::World& world) {
  for (int i = 0; i < world.objects(); ++i) {
    if (world.object_name(i) == object && !world.parked(i)) return i;
  }
  return std::nullopt;
}

class BringExperiment : public experiment::Task {
 public:
  BringExperiment(const Options& options, const experiment::Common& common)
      : options_(options),
        cell_(options.grasping),
        library_(recognition::LibraryOf(ModelsOf(options), options.bring.library)),
        grasps_(ReadGrasps(options)),
        seed_(common.seed) {}

  std::vector<Case> Cases() const override {
    std::vector<Case> cases;
    for (const std::string& object : cell_.options.objects) {
      const std::uint64_t of_object = base::DeriveSeed(base::DeriveSeed(seed_, "bring"), object);
      for (int i = 0; i < options_.bring.runs_per_object; ++i) {
        const nlohmann::ordered_json params = {{"object", object}, {"index", i}};
        cases.push_back({fmt::format("{}-{:04}", object, i), object,
                         base::DeriveSeed(of_object, static_cast<std::uint64_t>(i)),
                         params.dump()});
      }
    }
    return cases;
  }

  experiment::Result Run(const Case& which) const override { return RunCase(which, {}); }

  experiment::Result Replay(const Case& which,
                            const experiment::ReplayOptions& options) const override {
    return Aloud(which, {}, options);
  }

  experiment::Result Aloud(const Case& which, const std::function<void(const std::string&)>& say,
                           const experiment::ReplayOptions& options) const {
    const auto recorder = trial::MakeRecorder(cell_, which.id, options);
    recorder->KeepMoments([](const std::string& moment) {
      return moment == "start" || moment == "closed" || moment == "lifted" || moment == "taken";
    });
    BringObserver observer;
    observer.on_words = say;
    observer.execution = recorder->Observer();
    observer.on_attempt = [&](int attempt) {
      recorder->SetPrefix(fmt::format("{}_{:02}", which.id, attempt));
    };
    const auto result = RunCase(which, observer);
    recorder->Finish();
    return result;
  }

  void AddTo(experiment::Stamp& stamp) const override {
    stamp.identity["scene_hash"] = trial::SceneHash(cell_.options);
    stamp.identity["mujoco"] = sim::EngineVersion();
    trial::AddTitles(cell_.options, stamp);
  }

 private:
  experiment::Result RunCase(const Case& which, const BringObserver& observer) const {
    const auto params = nlohmann::json::parse(which.params);
    const std::string wanted = params.at("object");
    base::Stopwatch watch;
    trial::Redraws redraws;
    auto arranged = trial::ArrangeTrial(
        cell_, {OnTop(wanted, params.at("index")), params.at("index"), which.seed}, redraws);
    if (!arranged) return trial::NoArrangement(redraws);
    sim::World& world = arranged->world;
    auto target = NumberOf(wanted, world);
    if (target && options_.bring.absent) {
      world.ParkObject(*target);
      world.Settle();
      target.reset();
    }
    const double arrange_s = watch.Restart();
    const Bring run = BringObject({options_, cell_, library_, grasps_}, wanted, target, which.seed,
                                  world, observer);
    experiment::Result result = ResultOf(run, wanted, target.has_value());
    result.seconds.insert(result.seconds.begin(), {"arrange", arrange_s});
    result.seconds.emplace_back("bring", watch.Seconds());
    return result;
  }

  /// The object that an arrangement is drawn round. In a heap it lies on top, and the wanted one
  /// anywhere: the others take turns.
  std::string OnTop(const std::string& wanted, int index) const {
    const auto& objects = cell_.options.objects;
    const auto kind = cell_.options.arranger;
    const bool heap = kind == trial::kPile || kind == trial::kBox;
    if (!heap && !options_.bring.absent) return wanted;
    const auto own = static_cast<std::size_t>(std::ranges::find(objects, wanted) - objects.begin());
    if (objects.size() < 2) return wanted;
    const std::size_t step = 1 + static_cast<std::size_t>(index) % (objects.size() - 1);
    return objects[(own + step) % objects.size()];
  }

  Options options_;
  trial::Cell cell_;
  recognition::Library library_;
  GraspsOf grasps_;
  std::uint64_t seed_;
};

std::unique_ptr<experiment::Task> Read(base::YamlMap& map, const experiment::Common& common) {
  const Options options = ReadOptions(map);
  trial::CheckObjects(map, options.grasping);
  trial::RequireOwnDetector(map, options.grasping);
  for (const std::string& object : options.grasping.objects) {
    if (std::ranges::find(options.bring.known, object) == options.bring.known.end() &&
        !options.bring.absent) {
      map.Fail(
          "known",
          fmt::format("has no '{}', which is wanted: add it, or take it off `objects`", object));
    }
  }
  return std::make_unique<BringExperiment>(options, common);
}

}  // namespace

const experiment::TaskKind& BringTask() {
  static const experiment::TaskKind kind{
      .name = "bring",
      .description =
          "A known object among others is looked for, taken as its use asks for and "
          "handed over to a person. Beside the keys below it has all of "
          "`task: grasping` but `trials_per_object`.",
      .trials_key = "runs_per_object",
      .uses_seed = true,
      .success = trial::kHandedOver,
      .read = Read,
      .check = [](base::YamlMap& map) { return trial::CheckModels(ReadOptions(map).grasping); },
      .read_keys =
          [](base::YamlMap& map) {
            BringOptions options;
            ReadBringKeys(map, options);
          },
      .report = ReportOf};
  return kind;
}

experiment::Result BringAloud(const experiment::Task& task, const Case& which,
                              const std::function<void(const std::string&)>& say,
                              const experiment::ReplayOptions& options) {
  const auto* bring = dynamic_cast<const BringExperiment*>(&task);
  if (!bring) throw base::InputError("the experiment is not of `task: bring`");
  return bring->Aloud(which, say, options);
}

}  // namespace rangegrasp::bring
