#include "trial/grasping_task.h"

#include "base/error.h"
#include "base/file.h"
#include "sim/world.h"
#include "trial/options.h"
#include "trial/recorder.h"
#include "trial/registry.h"
#include "trial/table.h"

namespace rangegrasp::trial {
namespace {

experiment::Result ViewTrial(const Cell& cell, const TrialSpec& spec, experiment::View& view) {
  ViewRecorder recorder(cell);
  Attempt attempt;
  const auto result = RunTrial(cell, spec, &recorder.detector(), recorder.Observer(), &attempt);
  view = recorder.Finish(attempt);
  return result;
}

/// Runs a trial again; leaves pictures of every stage (`<id>_perceived.png`, `<id>_lifted.png`,
/// ...) in the folder and a film of the execution, where they are asked for; or the view, where
/// that is.
/// @throws base::InputError if there is no such camera, or no ffmpeg for the film.
experiment::Result ReplayTrial(const Cell& cell, const TrialSpec& spec,
                               const experiment::ReplayOptions& options) {
  if (options.view) return ViewTrial(cell, spec, *options.view);
  const auto recorder = MakeRecorder(cell, TrialId(spec), options);
  const auto result = RunTrial(cell, spec, &recorder->detector(), recorder->Observer());
  recorder->Finish();
  return result;
}

using experiment::Case;

// All objects of the experiment in the middle of the workspace: to be drawn, not to be moved.
sim::World WorldOfAll(const Cell& cell) {
  std::vector<sim::ObjectModel> models;
  for (const std::string& object : cell.options.objects) {
    models.push_back(ObjectModelOf(cell.options, object));
  }
  sim::World world(cell.options.scene, models, cell.options.physics);
  for (int i = 0; i < world.objects(); ++i) world.PlaceObject(i, cell.robot.X_WWorkspace);
  world.Refresh();
  return world;
}

class Grasping : public experiment::Task {
 public:
  Grasping(Options options, const experiment::Common& common)
      : cell_(std::move(options)), seed_(common.seed) {}

  std::vector<Case> Cases() const override {
    std::vector<Case> cases;
    for (const std::string& object : cell_.options.objects) {
      for (int i = 0; i < cell_.options.trials_per_object; ++i) {
        cases.push_back(CaseOf({object, i, TrialSeed(seed_, object, i)}));
      }
    }
    return cases;
  }

  void Prepare() const override {
    cell_.sensor->Prepare();
    if (cell_.sensor->Rehearses()) {
      cell_.sensor->Rehearse(WorldOfAll(cell_));
    }
  }

  void Hide(const std::filesystem::path& folder) override { cell_.Hide(folder); }

  experiment::Result Run(const Case& which) const override {
    return RunTrial(cell_, SpecOf(which));
  }

  experiment::Result Replay(const Case& which,
                            const experiment::ReplayOptions& options) const override {
    return ReplayTrial(cell_, SpecOf(which), options);
  }

  void AddTo(experiment::Stamp& stamp) const override {
    const Options& o = cell_.options;
    AddModelsTo(o, stamp);
    AddDetectorTo(o, stamp);
    AddTitles(o, stamp);
    if (!o.reference.empty()) stamp.data[kReference] = base::ReadFile(o.reference);
  }

  const Cell& cell() const { return cell_; }

 private:
  Cell cell_;
  std::uint64_t seed_;
};

std::unique_ptr<experiment::Task> Read(base::YamlMap& map, const experiment::Common& common) {
  Options options = ReadOptions(map);
  if (!ModelsPass(map, options, common)) return nullptr;
  CheckDetector(map, options, common.case_limit_s);
  options.seed = common.seed;
  return std::make_unique<Grasping>(std::move(options), common);
}

}  // namespace

const Cell& CellOf(const experiment::Task& task) {
  const auto* grasping = dynamic_cast<const Grasping*>(&task);
  if (grasping) return grasping->cell();
  throw base::InputError("this needs an experiment with `task: grasping`");
}

const experiment::TaskKind& GraspingTask() {
  static const experiment::TaskKind kind{
      .name = "grasping",
      .description = "Grasp attempts in simulation: one case a trial, one row an object.",
      .trials_key = "trials_per_object",
      .uses_seed = true,
      .success = "delivered",
      .stops_when_hopeless = true,
      .read = Read,
      .read_keys = [](base::YamlMap& map) { ReadOptions(map); },
      .report = ReportOf,
      .charts = ChartsOf,
      .has_views = true};
  return kind;
}

}  // namespace rangegrasp::trial
