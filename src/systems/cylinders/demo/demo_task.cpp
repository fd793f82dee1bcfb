#include "cylinders/demo/demo_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/image/png.h"
#include "base/stopwatch.h"
#include "base/units.h"
#include "base/words.h"
#include "cylinders/cylinder_view.h"
#include "cylinders/demo/demo_options.h"
#include "cylinders/demo/demo_report.h"
#include "cylinders/demo/demo_run.h"
#include "experiment/stage_seconds.h"
#include "geometry/cloud_file.h"
#include "geometry/draw/canvas.h"
#include "grasp/scene_view.h"
#include "sim/info.h"
#include "trial/hand_over.h"
#include "trial/objects.h"
#include "trial/recorder.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::demo {
namespace {

using experiment::Case;
using nlohmann::ordered_json;

// Of pictures.
constexpr int kWidth_px = 1280;
constexpr int kHeight_px = 960;
/// Beyond this nothing is near: a hand's width.
constexpr double kNear_m = 0.1;
/// An axis nearer to the vertical stands.
constexpr double kStanding_rad = base::Deg(45.0);

/// Of the surface next to the wanted cylinder; kNear_m if that is further off.
double ClearanceOf(const sim::World& world, int target) {
  double nearest_m = kNear_m;
  for (int other = 0; other < world.objects(); ++other) {
    if (other == target || world.parked(other)) continue;
    nearest_m = std::min(nearest_m, world.ObjectDistance(target, other, kNear_m));
  }
  return nearest_m;
}

/// What lies on the table, as truth has it.
ordered_json JsonOf(const trial::Arrangement& arranged) {
  const int target = arranged.target;
  const Eigen::Vector3d axis_W = arranged.world.ObjectPose(target).linear().col(2);
  return {{"stands", std::abs(axis_W.z()) > std::cos(kStanding_rad)},
          {"pose_class", arranged.pose_class},
          {"scene_objects", arranged.world.objects()},
          {"touching", arranged.touching},
          {"clearance_m", ClearanceOf(arranged.world, target)}};
}

ordered_json JsonOf(const std::optional<FoundError>& found) {
  if (!found) return nullptr;
  return {{"lies", found->lies},
          {"from_rim", found->from_rim},
          {"length_seen_m", found->length_seen_m},
          {"axis_error_rad", found->axis_rad},
          {"along_error_m", found->along_m},
          {"across_error_m", found->across_m}};
}

/// The tries' outcomes, and what the last one left.
void AddTries(const std::vector<Try>& tries, ordered_json& data) {
  data["tries"] = ordered_json::array();
  int moved = 0;
  int left_table = 0;
  for (const Try& one : tries) {
    data["tries"].push_back({{"outcome", one.outcome}, {"found", JsonOf(one.found)}});
    moved = std::max(moved, one.attempt.others.moved);
    left_table = std::max(left_table, one.attempt.others.left_table);
  }
  data.update(JsonOf(tries.back().attempt));
  data["others_moved"] = moved;
  data["others_left_table"] = left_table;
}

/// `<prefix>_scan.pcd` and `<prefix>_cylinders.png`.
void Draw(const cylinders::CylinderScene& scene, const geometry::Observation& observation,
          const std::string& prefix) {
  const geometry::RangeImage& image = observation.views.front().image;
  geometry::WriteCloud(prefix + "_scan.pcd", image);
  const auto view =
      draw::LookAtPoints(scene.cloud.points, scene.table.plane.normal, image.origins_C.front());
  image::WritePng(prefix + "_cylinders.png",
                  draw::Render(draw::DrawCylinders(scene), view, kWidth_px, kHeight_px));
}

class DemoExperiment : public experiment::Task {
 public:
  DemoExperiment(const Options& options, const experiment::Common& common)
      : options_(options), cell_(options.grasping), seed_(common.seed) {}

  // The cylinders are wanted in turn.
  std::vector<Case> Cases() const override {
    const auto& objects = cell_.options.objects;
    std::vector<Case> cases;
    for (int i = 0; i < options_.demo.runs; ++i) {
      const std::string& wanted = objects[static_cast<std::size_t>(i) % objects.size()];
      const ordered_json params = {{"object", wanted}, {"index", i}};
      cases.push_back(
          {fmt::format("run-{:04}", i), wanted,
           base::DeriveSeed(base::DeriveSeed(seed_, "demo"), static_cast<std::uint64_t>(i)),
           params.dump()});
    }
    return cases;
  }

  experiment::Result Run(const Case& which) const override { return RunCase(which, {}); }

  experiment::Result Replay(const Case& which,
                            const experiment::ReplayOptions& options) const override {
    const auto recorder = trial::MakeRecorder(cell_, which.id, options);
    Viewers viewers;
    viewers.execution = recorder->Observer();
    std::string prefix;
    viewers.on_try = [&](int number) {
      prefix = number == 1 ? which.id : fmt::format("{}_try{}", which.id, number);
      recorder->SetPrefix(prefix);
    };
    if (options.snapshots) {
      viewers.cylinders = [&](const cylinders::CylinderScene& scene,
                              const geometry::Observation& observation) {
        Draw(scene, observation, options.folder / prefix);
      };
    }
    const auto result = RunCase(which, viewers);
    recorder->Finish();
    return result;
  }

  void AddTo(experiment::Stamp& stamp) const override {
    stamp.identity["scene_hash"] = trial::SceneHash(cell_.options);
    stamp.identity["mujoco"] = sim::EngineVersion();
  }

 private:
  experiment::Result RunCase(const Case& which, const Viewers& viewers) const {
    const auto params = nlohmann::json::parse(which.params);
    const trial::TrialSpec spec{params.at("object"), params.at("index"), which.seed};
    base::Stopwatch watch;
    trial::Redraws redraws;
    auto arranged = trial::ArrangeTrial(cell_, spec, redraws);
    if (!arranged) return trial::NoArrangement(redraws);
    const double arrange_s = watch.Seconds();
    ordered_json data = JsonOf(*arranged);
    data["wanted"] = spec.object;
    for (const auto& [reason, count] : redraws) data["redraw_reasons"][base::Word(reason)] = count;
    const std::size_t wanted = static_cast<std::size_t>(spec.index) % options_.demo.given.size();
    const std::vector<Try> tries =
        RunDemo(options_, cell_, wanted, arranged->target, spec.seed, arranged->world, viewers);
    AddTries(tries, data);
    const Try& last = tries.back();
    experiment::Result result{
        last.outcome, last.attempt.stage, last.attempt.detail, data.dump(), {}};
    result.seconds.emplace_back("arrange", arrange_s);
    for (const Try& one : tries) {
      for (const auto& [stage, seconds] : one.attempt.seconds) {
        experiment::AddSeconds(stage, seconds, result.seconds);
      }
    }
    result.seconds.emplace_back("run", watch.Seconds());
    return result;
  }

  Options options_;
  trial::Cell cell_;
  std::uint64_t seed_;
};

std::unique_ptr<experiment::Task> Read(base::YamlMap& map, const experiment::Common& common) {
  const Options options = ReadOptions(map);
  trial::CheckObjects(map, options.grasping);
  trial::RequireOwnDetector(map, options.grasping);
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
      .success = trial::kHandedOver,
      .read = Read,
      .check = [](base::YamlMap& map) { return trial::CheckModels(ReadOptions(map).grasping); },
      .read_keys =
          [](base::YamlMap& map) {
            DemoOptions options;
            ReadDemoKeys(map, options);
          },
      .report = ReportOf};
  return kind;
}

}  // namespace rangegrasp::demo
