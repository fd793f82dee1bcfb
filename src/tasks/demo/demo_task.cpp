#include "tasks/demo/demo_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/stopwatch.h"
#include "core/units.h"
#include "draw/canvas.h"
#include "draw/cylinder_view.h"
#include "draw/scene_view.h"
#include "geometry/cloud_file.h"
#include "image/png.h"
#include "sensing/scan_truth.h"
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

// Of pictures.
constexpr int kWidth_px = 1280;
constexpr int kHeight_px = 960;
/// Beyond this nothing is near: a hand's width.
constexpr double kNear_m = 0.1;
/// An axis nearer to the vertical stands.
constexpr double kStanding_rad = core::Deg(45.0);

/// Of the surface next to the wanted cylinder; kNear_m if that is further off.
double ClearanceOf(const sim::World& world, int target) {
  double nearest_m = kNear_m;
  for (int other = 0; other < world.objects(); ++other) {
    if (other == target || world.parked(other)) continue;
    nearest_m = std::min(nearest_m, world.ObjectDistance(target, other, kNear_m));
  }
  return nearest_m;
}

/// Those that were measured.
std::ptrdiff_t SamplesOf(const grasping::Sensed& sensed, int object) {
  const auto label = static_cast<std::uint32_t>(object) + 1;
  std::ptrdiff_t samples = 0;
  for (const auto& truth : sensed.truth) {
    for (std::size_t i = 0; i < truth.label.size(); ++i) {
      const bool measured = truth.state[i] == sensing::SampleState::kMeasured;
      samples += measured && truth.label[i] == label ? 1 : 0;
    }
  }
  return samples;
}

/// A detected cylinder beside the true one.
ordered_json ErrorOf(const cylinders::FoundCylinder& found, const core::Pose& X_WO,
                     const Eigen::Vector3d& center_W) {
  const cylinders::Cylinder& c = found.cylinder_C;
  const Eigen::Vector3d axis_W = X_WO.linear().col(2);
  const Eigen::Vector3d off = c.center - center_W;
  const double along_m = off.dot(axis_W);
  return {{"lies", found.lies},
          {"from_rim", found.from_rim},
          {"length_seen_m", found.length_seen_m},
          {"axis_error_rad", std::acos(std::min(1.0, std::abs(axis_W.dot(c.axis))))},
          {"along_error_m", std::abs(along_m)},
          {"across_error_m", (off - along_m * axis_W).norm()}};
}

/// What lies on the table, as truth has it.
ordered_json JsonOf(const grasping::Arrangement& arranged, const grasping::Sensed& sensed) {
  const int target = arranged.target;
  const Eigen::Vector3d axis_W = arranged.world.ObjectPose(target).linear().col(2);
  return {{"stands", std::abs(axis_W.z()) > std::cos(kStanding_rad)},
          {"pose_class", arranged.pose_class},
          {"scene_objects", arranged.world.objects()},
          {"touching", arranged.touching},
          {"clearance_m", ClearanceOf(arranged.world, target)},
          {"target_samples", SamplesOf(sensed, target)}};
}

/// The models of cylinders are drawn round the middle of their height.
Eigen::Vector3d CenterOf(const core::Pose& X_WO) { return X_WO.translation(); }

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
           core::DeriveSeed(core::DeriveSeed(seed_, "demo"), static_cast<std::uint64_t>(i)),
           params.dump()});
    }
    return cases;
  }

  experiment::Result Run(const Case& which) const override { return RunCase(which, {}); }

  experiment::Result Replay(const Case& which,
                            const experiment::ReplayOptions& options) const override {
    grasping::Recorder recorder(cell_, which.id, options);
    CylinderObserver draw;
    if (options.snapshots) {
      draw = [&](const cylinders::CylinderScene& scene, const geometry::Observation& observation) {
        Draw(scene, observation, options.folder / which.id);
      };
    }
    const auto result = RunCase(which, {recorder.Observer(), draw});
    recorder.Finish();
    return result;
  }

  void AddTo(experiment::Stamp& stamp) const override {
    stamp.identity["scene_hash"] = grasping::SceneHash(cell_.options);
    stamp.identity["mujoco"] = sim::EngineVersion();
  }

 private:
  /// What a replay looks at.
  struct Viewers {
    sim::ExecutionObserver execution;
    CylinderObserver cylinders;
  };

  experiment::Result RunCase(const Case& which, const Viewers& viewers) const {
    const auto params = nlohmann::json::parse(which.params);
    const grasping::TrialSpec spec{params.at("object"), params.at("index"), which.seed};
    core::Stopwatch watch;
    grasping::Redraws redraws;
    auto arranged = grasping::ArrangeTrial(cell_, spec, redraws);
    if (!arranged) {
      return {
          experiment::kCrashed, "arrange", "no arrangement: " + grasping::Text(redraws), "{}", {}};
    }
    const double arrange_s = watch.Restart();
    const grasping::Sensed sensed = grasping::Look(cell_, arranged->world, spec.seed);
    const double scan_s = watch.Restart();

    ordered_json data = JsonOf(*arranged, sensed);
    data["wanted"] = spec.object;
    data["redraws"] = grasping::Total(redraws);
    const core::Pose X_WO = arranged->world.ObjectPose(arranged->target);
    const Eigen::Vector3d center_W = CenterOf(X_WO);
    const std::size_t wanted = static_cast<std::size_t>(spec.index) % options_.demo.given.size();
    const auto see = [&](const cylinders::CylinderScene& scene,
                         const geometry::Observation& observation) {
      for (const auto& found : scene.cylinders) {
        if (found.given == wanted) data["found"] = ErrorOf(found, X_WO, center_W);
      }
      if (viewers.cylinders) viewers.cylinders(scene, observation);
    };
    const auto detector = MakeDemoDetector(options_, cell_.robot, wanted, see);
    grasping::AttemptOptions attempt_options;
    attempt_options.seed = spec.seed;
    attempt_options.target = arranged->target;
    attempt_options.sensed = &sensed;
    attempt_options.detector = detector.get();
    attempt_options.observer = viewers.execution;
    if (options_.demo.delivery == Delivery::kHandOver) {
      core::Rng rng = grasping::StageStream(spec.seed, "user");
      attempt_options.user = UserFor(options_.demo, rng);
    }
    const grasping::Attempt attempt = grasping::RunAttempt(cell_, arranged->world, attempt_options);
    data.update(JsonOf(attempt));
    experiment::Result result{
        OutcomeOf(attempt, options_.demo.delivery), attempt.stage, attempt.detail, data.dump(), {}};
    result.seconds.emplace_back("arrange", arrange_s);
    result.seconds.emplace_back("scan", scan_s);
    result.seconds.insert(result.seconds.end(), attempt.seconds.begin(), attempt.seconds.end());
    result.seconds.emplace_back("run", watch.Seconds() + arrange_s + scan_s);
    return result;
  }

  Options options_;
  grasping::Cell cell_;
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
