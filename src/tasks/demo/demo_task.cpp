#include "tasks/demo/demo_task.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/stopwatch.h"
#include "sim/info.h"
#include "tasks/demo/demo_detector.h"
#include "tasks/demo/demo_options.h"
#include "tasks/demo/demo_report.h"
#include "tasks/grasping/recorder.h"
#include "tasks/grasping/trial.h"

namespace rangegrasp::tasks::demo {
namespace {

using experiment::Case;
using nlohmann::ordered_json;

class DemoExperiment : public experiment::Task {
 public:
  DemoExperiment(const Options& options, const experiment::Common& common)
      : options_(options), cell_(options.grasping), seed_(common.seed) {
    for (std::size_t i = 0; i < options_.demo.given.size(); ++i) {
      detectors_.push_back(MakeDemoDetector(options_, cell_.robot, i));
    }
  }

  // The cylinders are wanted in turn.
  std::vector<Case> Cases() const override {
    const auto& objects = cell_.options.objects;
    std::vector<Case> cases;
    for (int i = 0; i < options_.demo.runs; ++i) {
      const std::string& wanted = objects[static_cast<std::size_t>(i) % objects.size()];
      const ordered_json params = {{"object", wanted}, {"index", i}};
      cases.push_back(
          {fmt::format("run-{:04}", i), wanted,
           core::DeriveSeed(core::DeriveSeed(seed_, "demo"), static_cast<std::uint64_t>(i)),
           params.dump()});
    }
    return cases;
  }

  experiment::Result Run(const Case& which) const override { return RunCase(which, {}); }

  experiment::Result Replay(const Case& which,
                            const experiment::ReplayOptions& options) const override {
    grasping::Recorder recorder(cell_, which.id, options);
    const auto result = RunCase(which, recorder.Observer());
    recorder.Finish();
    return result;
  }

  void AddTo(experiment::Stamp& stamp) const override {
    stamp.identity["scene_hash"] = grasping::SceneHash(cell_.options);
    stamp.identity["mujoco"] = sim::EngineVersion();
  }

 private:
  experiment::Result RunCase(const Case& which, const sim::ExecutionObserver& observer) const {
    const auto params = nlohmann::json::parse(which.params);
    const grasping::TrialSpec spec{params.at("object"), params.at("index"), which.seed};
    const std::size_t wanted = static_cast<std::size_t>(spec.index) % detectors_.size();
    core::Stopwatch watch;
    grasping::Redraws redraws;
    auto arranged = grasping::ArrangeTrial(cell_, spec, redraws);
    if (!arranged) {
      return {
          experiment::kCrashed, "arrange", "no arrangement: " + grasping::Text(redraws), "{}", {}};
    }
    const double arrange_s = watch.Restart();
    grasping::AttemptOptions attempt_options;
    attempt_options.seed = spec.seed;
    attempt_options.target = arranged->target;
    attempt_options.detector = detectors_[wanted].get();
    attempt_options.observer = observer;
    if (options_.demo.delivery == Delivery::kHandOver) attempt_options.user = options_.demo.user;
    const grasping::Attempt attempt = grasping::RunAttempt(cell_, arranged->world, attempt_options);
    ordered_json data = {{"wanted", spec.object},
                         {"pose_class", arranged->pose_class},
                         {"scene_objects", arranged->world.objects()},
                         {"touching", arranged->touching},
                         {"redraws", grasping::Total(redraws)}};
    data.update(JsonOf(attempt));
    experiment::Result result{
        OutcomeOf(attempt, options_.demo.delivery), attempt.stage, attempt.detail, data.dump(), {}};
    result.seconds.emplace_back("arrange", arrange_s);
    result.seconds.insert(result.seconds.end(), attempt.seconds.begin(), attempt.seconds.end());
    result.seconds.emplace_back("run", watch.Seconds());
    return result;
  }

  Options options_;
  grasping::Cell cell_;
  std::vector<std::unique_ptr<grasping::Detector>> detectors_;
  std::uint64_t seed_;
};

std::unique_ptr<experiment::Task> Read(core::YamlMap& map, const experiment::Common& common) {
  const Options options = ReadOptions(map);
  grasping::CheckObjects(map, options.grasping);
  return std::make_unique<DemoExperiment>(options, common);
}

}  // namespace

const experiment::TaskKind& DemoTask() {
  static const experiment::TaskKind kind{
      .name = "demo",
      .description =
          "The live demo of chapter 4: given cylinders among other objects are found, "
          "grasped and handed over to a person. Beside the keys below it has all of "
          "`task: grasping` but `trials_per_object`.",
      .trials_key = "runs",
      .uses_seed = true,
      .success = kHandedOver,
      .read = Read,
      .read_keys =
          [](core::YamlMap& map) {
            DemoOptions options;
            ReadDemoKeys(map, options);
          },
      .report = ReportOf};
  return kind;
}

}  // namespace rangegrasp::tasks::demo
