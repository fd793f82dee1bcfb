#include "trial/recorder.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/installation.h"
#include "grasp/scene_view.h"
#include "sim/bodies.h"
#include "trial/registry.h"

namespace rangegrasp::trial {
namespace {

using experiment::View;

constexpr double kFramePeriod_s = 0.1;  // motions are smooth; the page interpolates between frames
constexpr double kMinForce_N = 0.05;
constexpr double kApproach_m = 0.06;  // drawn length of the approach to a grasp
// Maximum numbers of points. Thinning makes no visible difference, and the page loads faster.
constexpr std::size_t kMaxObjectPoints = 12000;  // per object
constexpr std::size_t kMaxRestPoints = 9000;     // each: table, outliers, no object

// The colors of the pictures of perceived scenes (grasp/scene_view.h).
const View::Color kTable{0.55F, 0.65F, 0.80F, 1.0F};
const View::Color kOutlier{0.9F, 0.1F, 0.1F, 1.0F};
const View::Color kRest{0.55F, 0.55F, 0.55F, 1.0F};
const View::Color kRim{0.0F, 0.0F, 0.0F, 1.0F};
const View::Color kFree{0.0F, 0.55F, 0.15F, 1.0F};
const View::Color kColliding{0.80F, 0.25F, 0.20F, 1.0F};
const View::Color kHand{0.85F, 0.68F, 0.55F, 0.75F};
constexpr float kSurfaceOpacity = 0.35F;

geometry::Points Thinned(const geometry::Points& points, std::size_t max) {
  if (points.size() <= max) return points;
  geometry::Points kept;
  for (std::size_t i = 0; i < max; ++i) kept.push_back(points[i * points.size() / max]);
  return kept;
}

void AddObject(const perception::Scene& scene, const perception::PerceivedObject& object,
               View::Color color, View& view) {
  view.points.push_back(
      {"objects", Thinned(geometry::Select(scene.cloud.points, object.points), kMaxObjectPoints),
       color});
  if (object.top && !object.top->rim.empty()) {
    auto rim = geometry::Select(scene.cloud.points, object.top->rim);
    rim.push_back(rim.front());
    view.lines.push_back({"rims", std::move(rim), kRim});
  }
  color.w() = kSurfaceOpacity;
  if (!object.surface_C.triangles.empty()) {
    view.surfaces.push_back({"completed surfaces", object.surface_C, color});
  }
}

void AddScene(const perception::Scene& scene, const Eigen::Vector3d& sensor_W, View& view) {
  const auto add = [&](const char* layer, const geometry::Points& points,
                       const View::Color& color) {
    view.points.push_back({layer, Thinned(points, kMaxRestPoints), color});
  };
  add("table", geometry::Select(scene.points_C, scene.table.points), kTable);
  add("outliers", geometry::Select(scene.points_C, scene.outliers), kOutlier);
  std::vector<bool> rest(scene.cloud.size(), true);
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    AddObject(scene, scene.objects[i], draw::PaletteColor(i), view);
    for (const auto p : scene.objects[i].points) rest[p] = false;
  }
  add("no object", geometry::Select(scene.cloud.points, geometry::PositionsOf(rest)), kRest);
  const auto look = draw::LookAtScene(scene, sensor_W);
  view.eye_W = look.eye;
  view.target_W = look.target;
}

// Draws a grasp as lines: the approach, and a fork from pad to pad.
void AddGrasp(const grasp::DetectedGrasp& grasp, const robot::HandModel& hand, View& view) {
  const auto& state = hand.AtGap(grasp.opening_m);
  const Eigen::Vector3d thumb = grasp.X_CH * state.thumb_pad_H;
  const Eigen::Vector3d finger = grasp.X_CH * state.finger_pad_H;
  const Eigen::Vector3d middle = 0.5 * (thumb + finger);
  const Eigen::Vector3d back = kApproach_m * grasp.approach_C;
  view.lines.push_back({grasp.collides ? "colliding grasps" : "free grasps",
                        {thumb, thumb - 0.4 * back, middle - 0.4 * back, middle - back,
                         middle - 0.4 * back, finger - 0.4 * back, finger},
                        grasp.collides ? kColliding : kFree});
}

// The executed grasp; if none was, the best collision-free one.
const grasp::DetectedGrasp* ChosenOf(const Attempt& attempt) {
  if (attempt.executed) return attempt.Grasp();
  const auto& grasps = attempt.detected.detection.grasps;
  const auto best = std::ranges::find(grasps, false, &grasp::DetectedGrasp::collides);
  return best == grasps.end() ? nullptr : &*best;
}

}  // namespace

void Recorder::SetAttempt(int number) {
  SetPrefix(number == 0 ? name_ : fmt::format("{}_{:02}", name_, number));
}

RecorderMaker& PictureMaker() {
  static RecorderMaker maker = nullptr;
  return maker;
}

std::unique_ptr<Recorder> MakeRecorder(const Cell& cell, const std::string& prefix,
                                       const experiment::ReplayOptions& options) {
  if (!options.snapshots && options.video.empty()) return std::make_unique<Recorder>(cell);
  if (PictureMaker()) return PictureMaker()(cell, prefix, options);
  base::CheckBuilt("option", options.snapshots ? "snapshots" : "video");
  throw base::InputError("this program was built without pictures and videos of trials");
}

ViewRecorder::ViewRecorder(const Cell& cell)
    : cell_(cell),
      detector_(
          MakeDetector(cell.options, cell.robot,
                       [this](const perception::Scene& scene, const std::vector<grasp::Grasp>&,
                              const geometry::Observation& observation) {
                         AddScene(scene, observation.views.front().image.origins_C.front(), view_);
                       })) {}

void ViewRecorder::OnMoment(const std::string& moment, const sim::World& world) {
  if (bodies_.empty()) {
    for (auto& body : sim::VisualBodies(world)) {
      const char* layer = body.object ? "objects as simulated" : "robot and table";
      view_.bodies.push_back({body.name, layer, std::move(body.mesh_B), body.color, {}});
      bodies_.push_back(body.body);
    }
  }
  auto& frame = view_.frames.emplace_back();
  frame.time_s = world.time_s();
  if (moment != "frame") frame.moment = moment;
  for (const auto& [point_W, force_W] : sim::HandForces(world, kMinForce_N)) {
    frame.forces.push_back({point_W, force_W});
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    view_.bodies[i].X_WB.push_back(sim::BodyPose(world, bodies_[i]));
  }
}

sim::ExecutionObserver ViewRecorder::Observer() {
  return {.on_moment = [this](const std::string& moment,
                              sim::World& world) { OnMoment(moment, world); },
          .frame_period_s = kFramePeriod_s};
}

View ViewRecorder::Finish(const Attempt& attempt) {
  const robot::HandModel& hand = cell_.robot.hand();
  for (const auto& grasp : attempt.detected.detection.grasps) AddGrasp(grasp, hand, view_);
  if (const auto* chosen = ChosenOf(attempt)) {
    view_.surfaces.push_back(
        {"chosen grasp", draw::HandMesh(hand, chosen->opening_m, chosen->X_CH), kHand});
  }
  return std::move(view_);
}

}  // namespace rangegrasp::trial
