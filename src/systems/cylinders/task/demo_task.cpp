#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>
#include <vector>

#include "base/image/image.h"
#include "base/stopwatch.h"
#include "base/units.h"
#include "base/words.h"
#include "cylinders/task/cylinders_task.h"
#include "cylinders/task/demo_detector.h"
#include "geometry/cloud_file.h"
#include "geometry/draw/canvas.h"
#include "geometry/shape.h"
#include "grasp/scene_view.h"
#include "sim/world.h"
#include "trial/options.h"
#include "trial/recorder.h"
#include "trial/registry.h"

namespace rangegrasp::draw {
namespace {

// Colors as named in the dissertation's figures.
const Color kTable{0.70F, 0.78F, 0.88F, 1.0F};
const Color kOutlier{0.9F, 0.1F, 0.1F, 1.0F};
const Color kRest{0.65F, 0.65F, 0.65F, 1.0F};
const Color kCurved{0.1F, 0.65F, 0.2F, 1.0F};
const Color kEdge{0.95F, 0.55F, 0.1F, 1.0F};
const Color kBarrel{0.1F, 0.2F, 0.9F, 1.0F};
const Color kAxis{0.0F, 0.0F, 0.0F, 1.0F};
constexpr float kOpacity = 0.35F;  // of a cylinder, so that the points on it remain visible
constexpr float kDot_px = 1.5F;
constexpr double kBeyond = 0.15;  // share of its height by which the axis sticks out

geometry::TriangleMesh MeshOf(const cylinders::Cylinder& cylinder) {
  geometry::Shape shape;
  shape.kind = geometry::Shape::Kind::kCylinder;
  shape.size = {cylinder.radius_m, 0.5 * cylinder.height_m, 0.0};
  shape.X_BS = base::MakePose(base::TurnOnto(Eigen::Vector3d::UnitZ(), cylinder.axis).matrix(),
                              cylinder.center);
  return geometry::Tessellate(shape, 48);
}

}  // namespace

void DrawCylinders(const cylinders::CylinderScene& scene, const Eigen::Vector3d& sensor_origin_C,
                   const std::filesystem::path& png) {
  Canvas canvas;
  const auto& cloud = scene.cloud.points;
  canvas.dots.push_back({geometry::Select(scene.points_C, scene.table.points), kTable, kDot_px});
  canvas.dots.push_back({geometry::Select(scene.points_C, scene.outliers), kOutlier, 4.0F});
  std::vector<bool> marked(cloud.size(), false);
  const auto mark = [&](const geometry::Indices& positions, const Color& color,
                        float size_px = 2.5F) {
    geometry::Points points;
    for (const auto i : positions) {
      if (!marked[i]) points.push_back(cloud[i]);
      marked[i] = true;
    }
    canvas.dots.push_back({std::move(points), color, size_px});
  };
  for (const auto& found : scene.cylinders) mark(found.barrel, kBarrel);
  mark(scene.curved, kCurved);
  mark(scene.edges, kEdge);
  geometry::Indices all(cloud.size());
  std::iota(all.begin(), all.end(), 0u);
  mark(all, kRest, kDot_px);
  for (const auto& found : scene.cylinders) {
    const cylinders::Cylinder& c = found.cylinder_C;
    const Eigen::Vector3d half = (0.5 + kBeyond) * c.height_m * c.axis;
    canvas.lines.push_back({{c.center - half, c.center + half}, kAxis, 3.0F});
    Color color = PaletteColor(found.given);
    color.w() = kOpacity;
    canvas.surfaces.push_back({MeshOf(c), color});
  }
  const View view = LookAtPoints(cloud, scene.table.plane.normal, sensor_origin_C);
  image::WritePng(png, Render(canvas, view, 1280, 960));
}

}  // namespace rangegrasp::draw

namespace rangegrasp::cylinders {
bool KnowsItFailed(const trial::Attempt& attempt, Delivery delivery) {
  if (attempt.outcome == trial::Outcome::kCrashed) return false;
  if (!attempt.log) return true;
  if (delivery == Delivery::kHandOver) return !attempt.log->hand_over;
  return !attempt.log->aperture.feels_object_after_carry;
}

namespace {

using experiment::Case;
using nlohmann::ordered_json;

/// Objects beyond this distance are not near: a hand's width.
constexpr double kNear_m = 0.1;
/// An axis at less than this to the vertical stands.
constexpr double kStanding_rad = base::Deg(45.0);

/// Observers of a replay; each may be empty.
struct Viewers {
  sim::ExecutionObserver execution;
  CylinderObserver cylinders;
  std::function<void(int)> on_try;  ///< called before each try with its number, from 1
};

/// One try: a scan of the table, and a grasp if the wanted cylinder is found.
struct Try {
  trial::Attempt attempt;
  std::string outcome;
  ordered_json found;  ///< its deviation from the true one; null if not found
};

/// Errors of a detected cylinder; the true one has its origin in the center and z along the axis.
ordered_json ErrorOf(const FoundCylinder& found, const base::Pose& X_WO) {
  const Cylinder& c = found.cylinder_C;
  const Eigen::Vector3d axis_W = X_WO.linear().col(2);
  const Eigen::Vector3d off = c.center - X_WO.translation();
  const double along_m = off.dot(axis_W);
  return {{"lies", found.lies},
          {"from_rim", found.IsFromRim()},
          {"length_seen_m", found.length_seen_m},
          {"axis_error_rad", std::acos(std::min(1.0, std::abs(axis_W.dot(c.axis))))},
          {"along_error_m", std::abs(along_m)},
          {"across_error_m", (off - along_m * axis_W).norm()}};
}

/// The outcome judged by ground truth: whether another object was grasped.
std::string OutcomeOf(const trial::Attempt& attempt, int target, Delivery delivery) {
  const auto object = attempt.log ? std::optional(attempt.log->target) : attempt.target;
  if (!attempt.detected.detection.objects.empty() && object && *object != target) {
    return std::string(base::Word(trial::Outcome::kWrongTarget));
  }
  if (delivery == Delivery::kPlace) return std::string(base::Word(attempt.outcome));
  return trial::HandOverOutcome(attempt);
}

/// Makes up to options.max_tries tries, until by its detection and the hand's joints the robot
/// believes the wanted cylinder is delivered. Each starts at home with a scan and has its own
/// random streams.
/// @param wanted  position in options.given
/// @param target  index of the true object in the world
std::vector<Try> RunDemo(const DemoOptions& options, const trial::Cell& cell, std::size_t wanted,
                         int target, std::uint64_t seed, sim::World& world,
                         const Viewers& viewers) {
  std::vector<Try> tries;
  for (int number = 1; number <= options.max_tries; ++number) {
    if (number > 1) trial::GoHome(cell, world);
    if (viewers.on_try) viewers.on_try(number);
    Try& one = tries.emplace_back();
    const base::Pose X_WO = world.ObjectPose(target);
    const auto see = [&](const CylinderScene& scene, const geometry::Observation& observation) {
      if (const auto* found = scene.Find(wanted)) one.found = ErrorOf(*found, X_WO);
      if (viewers.cylinders) viewers.cylinders(scene, observation);
    };
    const auto detector = MakeDemoDetector(options, cell.robot, wanted, see);
    trial::AttemptOptions attempt;
    attempt.seed = number == 1 ? seed
                               : base::DeriveSeed(base::DeriveSeed(seed, "try"),
                                                  static_cast<std::uint64_t>(number));
    attempt.detector = detector.get();
    attempt.observer = viewers.execution;
    if (options.delivery == Delivery::kHandOver) {
      attempt.user = trial::UserOf(options.hand_over, cell.robot, attempt.seed);
    }
    one.attempt = trial::RunAttempt(cell, world, attempt);
    one.outcome = OutcomeOf(one.attempt, target, options.delivery);
    if (!KnowsItFailed(one.attempt, options.delivery)) break;
  }
  return tries;
}

/// Distance from the wanted cylinder to the nearest object; kNear_m if that is further away.
double ClearanceOf(const sim::World& world, int target) {
  double nearest_m = kNear_m;
  for (int other = 0; other < world.objects(); ++other) {
    if (other == target || world.parked(other)) continue;
    nearest_m = std::min(nearest_m, world.ObjectDistance(target, other, kNear_m));
  }
  return nearest_m;
}

/// Ground truth of the objects on the table.
ordered_json JsonOf(const trial::Arrangement& arranged) {
  const int target = arranged.target;
  const Eigen::Vector3d axis_W = arranged.world.ObjectPose(target).linear().col(2);
  return {{"stands", std::abs(axis_W.z()) > std::cos(kStanding_rad)},
          {"pose_class", arranged.pose_class},
          {"scene_objects", arranged.world.objects()},
          {"touching", arranged.touching},
          {"clearance_m", ClearanceOf(arranged.world, target)}};
}

/// Adds the outcomes of the tries and the data of the last one.
void AddTries(const std::vector<Try>& tries, ordered_json& data) {
  data["tries"] = ordered_json::array();
  int moved = 0;
  int left_table = 0;
  for (const Try& one : tries) {
    data["tries"].push_back({{"outcome", one.outcome},
                             {"found", one.found},
                             {"others_moved", one.attempt.others.moved}});
    moved = std::max(moved, one.attempt.others.moved);
    left_table = std::max(left_table, one.attempt.others.left_table);
  }
  data.update(JsonOf(tries.back().attempt));
  data["others_moved"] = moved;
  data["others_left_table"] = left_table;
}

class DemoExperiment : public trial::SceneTask {
 public:
  DemoExperiment(const DemoOptions& options, const experiment::Common& common)
      : options_(options), cell_(options.grasping), seed_(common.seed) {}

  // The cylinders are wanted in turn.
  std::vector<Case> Cases() const override {
    const auto& objects = cell_.options.objects;
    std::vector<Case> cases;
    for (int i = 0; i < options_.runs; ++i) {
      const std::string& wanted = objects[static_cast<std::size_t>(i) % objects.size()];
      cases.push_back(
          {fmt::format("run-{:04}", i),
           wanted,
           base::DeriveSeed(base::DeriveSeed(seed_, "demo"), static_cast<std::uint64_t>(i)),
           {{"object", wanted}, {"index", i}}});
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
      viewers.cylinders = [&](const CylinderScene& scene,
                              const geometry::Observation& observation) {
        const std::string path = options.folder / prefix;
        const geometry::RangeImage& image = observation.views.front().image;
        geometry::WriteCloud(path + "_scan.pcd", image);
        draw::DrawCylinders(scene, image.origins_C.front(), path + "_cylinders.png");
      };
    }
    const auto result = RunCase(which, viewers);
    recorder->Finish();
    return result;
  }

  void AddTo(experiment::Stamp& stamp) const override { trial::AddModelsTo(cell_.options, stamp); }

  const trial::Cell& cell() const override { return cell_; }

 private:
  experiment::Result RunCase(const Case& which, const Viewers& viewers) const {
    const trial::TrialSpec spec = trial::SpecOf(which);
    base::Stopwatch watch;
    trial::Redraws redraws;
    auto arranged = Arrange(which, redraws);
    if (!arranged) return trial::NoArrangement(redraws);
    const double arrange_s = watch.Seconds();
    ordered_json data = JsonOf(*arranged);
    data["wanted"] = spec.object;
    for (const auto& [reason, count] : redraws) data["redraw_reasons"][base::Word(reason)] = count;
    const std::size_t wanted = static_cast<std::size_t>(spec.index) % options_.given.size();
    const std::vector<Try> tries =
        RunDemo(options_, cell_, wanted, arranged->target, spec.seed, arranged->world, viewers);
    AddTries(tries, data);
    const Try& last = tries.back();
    // The attempt's detail says why the object, which a person has, is not at the delivery place.
    const bool handed_over = last.outcome == trial::kHandedOver;
    experiment::Result result{last.outcome,
                              last.attempt.stage,
                              handed_over ? "" : last.attempt.detail,
                              data.dump(),
                              {{"arrange", arrange_s}}};
    for (const Try& one : tries) {
      for (const auto& [stage, seconds] : one.attempt.seconds) {
        experiment::AddSeconds(stage, seconds, result.seconds);
      }
    }
    result.seconds.emplace_back("run", watch.Seconds());
    return result;
  }

  DemoOptions options_;
  trial::Cell cell_;
  std::uint64_t seed_;
};

}  // namespace

const experiment::TaskKind& DemoTask() {
  static const experiment::TaskKind kind{
      .name = "cylinder_demo",
      .description =
          "The live demo of chapter 4: given cylinders among other objects are found, grasped and "
          "handed over to a person. Besides the keys below it has all keys of `task: grasping` "
          "except `trials_per_object`.",
      .trials_key = "runs",
      .uses_seed = true,
      .success = trial::kHandedOver,
      .read = [](base::YamlMap& map,
                 const experiment::Common& common) -> std::unique_ptr<experiment::Task> {
        const DemoOptions options = ReadDemo(map, common.seed);
        if (!trial::ModelsPass(map, options.grasping, common)) return nullptr;
        CheckGiven(map, options);
        trial::RequireOwnDetector(map, options.grasping);
        return std::make_unique<DemoExperiment>(options, common);
      },
      .read_keys = [](base::YamlMap& map) { ReadDemoKeys(map); },
      .report = DemoReport};
  return kind;
}

}  // namespace rangegrasp::cylinders
