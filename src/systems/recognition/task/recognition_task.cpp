#include "recognition/task/recognition_task.h"

#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/stopwatch.h"
#include "base/words.h"
#include "grasp/workspace.h"
#include "perception/perceive.h"
#include "recognition/looks.h"
#include "recognition/task/known_objects.h"
#include "recognition/task/recognition_judge.h"
#include "recognition/task/recognition_options.h"
#include "recognition/task/recognition_report.h"
#include "recognition/views/looker.h"
#include "sim/info.h"
#include "trial/objects.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::recognition_task {
namespace {

using experiment::Case;
using nlohmann::ordered_json;

std::vector<sim::ObjectModel> ModelsOf(const trial::Options& options, const std::string& without) {
  std::vector<sim::ObjectModel> models;
  for (const std::string& object : options.objects) {
    if (object != without) models.push_back(trial::ObjectModelOf(options, object));
  }
  return models;
}

/// By the object that each lacks; "": the whole one.
std::map<std::string, recognition::Library> LibrariesOf(const Options& options) {
  std::map<std::string, recognition::Library> libraries;
  if (!options.without_target) {
    libraries.emplace("", recognition::LibraryOf(ModelsOf(options.grasping, ""), options.library));
    return libraries;
  }
  for (const std::string& object : options.grasping.objects) {
    libraries.emplace(object,
                      recognition::LibraryOf(ModelsOf(options.grasping, object), options.library));
  }
  return libraries;
}

/// x, y, z [m], then the quaternion w, x, y, z.
ordered_json JsonOf(const base::Pose& X_WO) {
  const Eigen::Vector3d& p = X_WO.translation();
  const Eigen::Quaterniond q(X_WO.linear());
  return {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()};
}

ordered_json JsonOf(const Judgement& judgement, const sim::World& world, int target,
                    const Options& options) {
  ordered_json finds = ordered_json::array();
  for (const JudgedFind& find : judgement.finds) {
    const bool near = find.named_right && find.off.distance_m <= options.max_distance_m &&
                      find.off.angle_rad <= options.max_angle_rad;
    finds.push_back({{"object", find.found->object},
                     {"truth", find.truth < 0 ? "" : world.object_name(find.truth)},
                     {"is_target", find.truth == target},
                     {"named_right", find.named_right},
                     {"near", near},
                     {"distance_m", find.off.distance_m},
                     {"angle_rad", find.off.angle_rad},
                     {"alternatives", find.found->alternatives_CB.size()},
                     {"score", find.found->score},
                     {"color", find.found->color},
                     {"share_seen", find.found->share_seen},
                     {"violations", find.found->violations},
                     {"hugging", find.found->hugging},
                     {"runner_up", find.found->runner_up},
                     {"rms_m", find.found->rms_m},
                     {"samples", find.found->samples.size()}});
  }
  return finds;
}

class Recognition : public experiment::Task {
 public:
  Recognition(const Options& options, const experiment::Common& common)
      : options_(options),
        cell_(options.grasping),
        libraries_(LibrariesOf(options)),
        seed_(common.seed) {}

  std::vector<Case> Cases() const override {
    std::vector<Case> cases;
    for (const std::string& object : cell_.options.objects) {
      for (int i = 0; i < cell_.options.trials_per_object; ++i) {
        const trial::TrialSpec spec{object, i, trial::TrialSeed(seed_, object, i)};
        const ordered_json params = {{"object", object}, {"index", i}};
        cases.push_back({trial::TrialId(spec), object, spec.seed, params.dump()});
      }
    }
    return cases;
  }

  experiment::Result Run(const Case& which) const override {
    const auto params = nlohmann::json::parse(which.params);
    const trial::TrialSpec spec{params.at("object"), params.at("index"), which.seed};
    base::Stopwatch watch;
    trial::Redraws redraws;
    auto arranged = trial::ArrangeTrial(cell_, spec, redraws);
    if (!arranged) return trial::NoArrangement(redraws);
    experiment::Result result;
    result.seconds.emplace_back("arrange", watch.Restart());
    const Recognized seen = LookUntilDone(arranged->world, spec, result);
    const auto& library = LibraryFor(spec);
    const Judgement judgement =
        Judge(seen.found, library, seen.sensed, arranged->world, arranged->target, options_);
    result.outcome = base::Word(judgement.outcome);
    result.stage = "recognize";
    result.data =
        ordered_json({{"pose_class", arranged->pose_class},
                      {"scene_objects", arranged->world.objects()},
                      {"objects", seen.scene.objects.size()},
                      {"views", seen.sensed.observation.views.size()},
                      {"target_pose", JsonOf(arranged->world.ObjectPose(arranged->target))},
                      {"finds", JsonOf(judgement, arranged->world, arranged->target, options_)}})
            .dump();
    return result;
  }

  experiment::Result Replay(const Case& which, const experiment::ReplayOptions&) const override {
    return Run(which);
  }

  void AddTo(experiment::Stamp& stamp) const override {
    stamp.identity["scene_hash"] = trial::SceneHash(cell_.options);
    stamp.identity["mujoco"] = sim::EngineVersion();
    trial::AddTitles(cell_.options, stamp);
  }

 private:
  /// What the views so far tell.
  struct Recognized {
    trial::Sensed sensed;
    perception::Scene scene;
    std::vector<recognition::FoundObject> found;
  };

  const recognition::Library& LibraryFor(const trial::TrialSpec& spec) const {
    return libraries_.at(options_.without_target ? spec.object : "");
  }

  /// From the fixed sensor, then from the wrist: as often as `views` says, at the highest thing; or
  /// no more often than that, at what is still open.
  Recognized LookUntilDone(sim::World& world, const trial::TrialSpec& spec,
                           experiment::Result& result) const {
    base::Stopwatch watch;
    Recognized seen;
    seen.sensed = trial::Look(cell_, world, spec.seed);
    const bool again = Views() > 1;
    if (again && !options_.until_sure) {
      seen.sensed = views::LookAround(cell_, std::move(seen.sensed), world, spec.seed).sensed;
    }
    Seconds seconds{watch.Restart()};
    Recognize(spec, seen, seconds);
    if (again && options_.until_sure) LookAtWhatIsOpen(world, spec, seen, seconds);
    result.seconds.emplace_back("scan", seconds.scan);
    result.seconds.emplace_back("perceive", seconds.perceive);
    result.seconds.emplace_back("recognize", seconds.recognize);
    return seen;
  }

  int Views() const { return trial::Of<views::LookOptions>(cell_.options, views::kLooks).views; }

  struct Seconds {
    double scan = 0.0, perceive = 0.0, recognize = 0.0;
  };

  void Recognize(const trial::TrialSpec& spec, Recognized& seen, Seconds& seconds) const {
    base::Stopwatch watch;
    base::Rng perceive = trial::StageStream(spec.seed, "perceive");
    seen.scene =
        perception::Perceive(seen.sensed.observation, options_.grasping.perception, perceive,
                             trial::WorkspaceOf(cell_.robot, options_.grasping.workspace_margin_m));
    seconds.perceive += watch.Restart();
    base::Rng rng = trial::StageStream(spec.seed, "recognize");
    seen.found =
        recognition::Recognize(seen.sensed.observation, seen.scene, LibraryFor(spec),
                               options_.recognition, rng, recognition::SureOnes(seen.found));
    seconds.recognize += watch.Seconds();
  }

  void LookAtWhatIsOpen(sim::World& world, const trial::TrialSpec& spec, Recognized& seen,
                        Seconds& seconds) const {
    views::Looker looker(cell_.options, cell_.robot, spec.seed);
    Eigen::VectorXd q = cell_.robot.home;
    for (int view = 1; view < Views(); ++view) {
      base::Stopwatch watch;
      const bool looked = LookAtFirstOpen(looker, world, q, seen);
      seconds.scan += watch.Seconds();
      if (!looked) break;
      Recognize(spec, seen, seconds);
    }
  }

  /// @return whether a view was added: that of the topmost open object that a look is worth at
  bool LookAtFirstOpen(views::Looker& looker, sim::World& world, Eigen::VectorXd& q,
                       Recognized& seen) const {
    const auto open = recognition::OpenObjects(seen.scene, seen.found, options_.recognition);
    for (const std::size_t object : open) {
      const auto region_W =
          looker.RegionAbout(seen.scene.objects[object].center_C, seen.sensed.observation);
      const auto look = looker.LookAt(region_W, world, q, seen.sensed);
      if (look) return look->arrived;
    }
    return false;
  }

  Options options_;
  trial::Cell cell_;
  std::map<std::string, recognition::Library> libraries_;
  std::uint64_t seed_;
};

std::unique_ptr<experiment::Task> Read(base::YamlMap& map, const experiment::Common& common) {
  Options options = ReadOptions(map);
  trial::CheckObjects(map, options.grasping);
  trial::RequireOwnDetector(map, options.grasping);
  options.grasping.seed = common.seed;
  return std::make_unique<Recognition>(options, common);
}

}  // namespace

const experiment::TaskKind& RecognitionTask() {
  static const experiment::TaskKind kind{
      .name = "recognition",
      .description =
          "Known objects (chapter 7): they are found in a scan, with their poses. Beside "
          "the keys below it has all of `task: grasping`.",
      .trials_key = "trials_per_object",
      .uses_seed = true,
      .success = "found",
      .read = Read,
      .check = [](base::YamlMap& map) { return trial::CheckModels(ReadOptions(map).grasping); },
      .read_keys =
          [](base::YamlMap& map) {
            Options options;
            ReadRecognitionKeys(map, options);
          },
      .report = ReportOf};
  return kind;
}

}  // namespace rangegrasp::recognition_task
