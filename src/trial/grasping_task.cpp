#include "trial/grasping_task.h"

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "sim/world.h"
#include "trial/arranger.h"
#include "trial/options.h"
#include "trial/recorder.h"
#include "trial/registry.h"
#include "trial/table.h"

namespace rangegrasp::trial {
namespace {

using experiment::Case;
using experiment::ReplayOptions;
using experiment::Result;
using experiment::Stamp;
using nlohmann::ordered_json;

// All objects of the experiment at the center of the workspace, for rendering only.
sim::World WorldOfAll(const Cell& cell) {
  sim::World world = WorldOf(cell.options, cell.options.objects);
  for (int i = 0; i < world.objects(); ++i) world.PlaceObject(i, cell.robot.X_WWorkspace);
  world.Refresh();
  return world;
}

class Grasping : public SceneTask {
 public:
  Grasping(Options options, const experiment::Common& common)
      : cell_(std::move(options)), seed_(common.seed) {}

  std::vector<Case> Cases() const override { return TrialsOf(cell_.options, seed_); }

  void Prepare() const override {
    cell_.sensor->Prepare();
    if (cell_.sensor->Rehearses()) cell_.sensor->Rehearse(WorldOfAll(cell_));
  }

  void Hide(const std::filesystem::path& folder) override { cell_.Hide(folder); }

  Result Run(const Case& which) const override { return RunTrial(cell_, SpecOf(which)); }

  // Writes pictures of every stage (`<id>_perceived.png`, `<id>_lifted.png`, ...) and a video of
  // the execution, or fills the view.
  // @throws base::InputError also if the camera does not exist, or there is no ffmpeg for a video.
  Result Replay(const Case& which, const ReplayOptions& options) const override {
    const TrialSpec spec = SpecOf(which);
    if (options.view) {
      ViewRecorder recorder(cell_);
      Attempt attempt;
      auto result = RunTrial(cell_, spec, &recorder.detector(), recorder.Observer(), &attempt);
      *options.view = recorder.Finish(attempt);
      return result;
    }
    const auto recorder = MakeRecorder(cell_, which.id, options);
    auto result = RunTrial(cell_, spec, &recorder->detector(), recorder->Observer());
    recorder->Finish();
    return result;
  }

  void AddTo(Stamp& stamp) const override {
    const Options& o = cell_.options;
    AddModelsTo(o, stamp);
    FindDetector(o.detector)->add_to(o, stamp);
    AddTitles(o, stamp);
    if (!o.reference.empty()) {
      stamp.data[experiment::kReferenceKey] = experiment::PublishedText(o.reference);
    }
  }

  const Cell& cell() const override { return cell_; }

 private:
  Cell cell_;
  std::uint64_t seed_;
};

// A trial grasps the topmost object, and succeeds with the target.
std::vector<base::Finding> ScatteredWarning(const base::YamlMap& map, const Options& options) {
  if (options.arranger != kScattered) return {};
  return {{.error = false,
           .where = map.PlaceOf("arrangement").value_or(map.file().string()),
           .element = "key 'arrangement'",
           .what = "scattered does not make the target the topmost object: trials that grasp "
                   "another one count as not detected",
           .cure = "use touching, side_by_side, box or pile"}};
}

std::unique_ptr<experiment::Task> Read(base::YamlMap& map, const experiment::Common& common) {
  Options options = ReadOptions(map, common.seed);
  if (!ModelsPass(map, options, common, ScatteredWarning(map, options))) return nullptr;
  FindDetector(options.detector)->check(map, options, common.case_limit_s);
  return std::make_unique<Grasping>(std::move(options), common);
}

}  // namespace

std::vector<experiment::Case> TrialsOf(const Options& options, std::uint64_t seed) {
  std::vector<experiment::Case> cases;
  for (const std::string& object : options.objects) {
    for (int i = 0; i < options.trials_per_object; ++i) {
      cases.push_back(CaseOf({object, i, TrialSeed(seed, object, i)}));
    }
  }
  return cases;
}

const Cell& CellOf(const experiment::Task& task) {
  const auto* grasping = dynamic_cast<const Grasping*>(&task);
  if (grasping) return grasping->cell();
  throw base::InputError("this needs an experiment with `task: grasping`");
}

const experiment::TaskKind& GraspingTask() {
  static const experiment::TaskKind kind{
      .name = "grasping",
      .description = "Grasp attempts in simulation: one case per trial, one table row per object.",
      .trials_key = "trials_per_object",
      .uses_seed = true,
      .success = "delivered",
      .stops_when_hopeless = true,
      .unusable = std::string(base::Word(Outcome::kDetectorFailed)),
      .read = Read,
      .read_keys = [](base::YamlMap& map) { ReadOptions(map, experiment::Common().seed); },
      .report = ReportOf,
      .charts = ChartsOf,
      .summary = [](const Result& result) { return GraspText(ordered_json::parse(result.data)); },
      .has_views = true};
  return kind;
}

}  // namespace rangegrasp::trial
