#include "tasks/grasping/detector.h"

#include <algorithm>

#include "core/stopwatch.h"
#include "perception/perceive.h"
#include "tasks/grasping/handle_grasps.h"
#include "tasks/grasping/outside_detector.h"
#include "tasks/grasping/view_obstacles.h"
#include "tasks/grasping/workspace.h"

namespace rangegrasp::tasks::grasping {
namespace {

// Moves the object whose turn is first before the others. @return whether there is one.
bool PutFirst(const Turn& turn, perception::Scene& scene) {
  if (!turn) return true;
  auto& objects = scene.objects;
  auto first = objects.end();
  int first_turn = 0;
  for (auto object = objects.begin(); object != objects.end(); ++object) {
    const auto its = turn(scene.SamplesOf(*object));
    if (!its || (first != objects.end() && *its >= first_turn)) continue;
    first = object;
    first_turn = *its;
  }
  if (first == objects.end()) return false;
  std::rotate(objects.begin(), first, first + 1);
  return true;
}

class DissertationDetector : public Detector {
 public:
  DissertationDetector(const Options& options, const robot::Robot& robot, SceneObserver observer)
      : options_(options), robot_(robot), observer_(std::move(observer)) {}

  Detected Detect(const geometry::Observation& observation, core::Rng& rng,
                  const Turn& turn) const override {
    Detected detected;
    core::Stopwatch watch;
    perception::Scene scene = perception::Perceive(
        observation, options_.perception, rng, WorkspaceOf(robot_, options_.workspace_margin_m));
    detected.seconds.emplace_back("perceive", watch.Restart());
    for (const auto& [step, seconds] : scene.seconds) {
      detected.seconds.emplace_back("perceive: " + step, seconds);
    }
    detected.has_turn = PutFirst(turn, scene);
    grasp::Obstacles obstacles;
    std::vector<grasp::Grasp> grasps;
    if (options_.take == TakeKind::kHandle) JoinCutOffHandle(scene);
    if (detected.has_turn && !scene.objects.empty()) {
      obstacles = ObstaclesOfViews(scene, 0, observation, options_.obstacles);
      detected.seconds.emplace_back("obstacles", watch.Restart());
      grasps = Grasps(scene, obstacles.measured_C, detected.why_none);
      detected.seconds.emplace_back("grasp", watch.Restart());
    }
    if (observer_) observer_(scene, grasps, observation);
    detected.segments = static_cast<int>(scene.segments.size());
    detected.detection = grasp::DetectionFrom(scene, grasps);
    if (options_.take == TakeKind::kHandle) {
      for (grasp::DetectedGrasp& grasp : detected.detection.grasps) grasp.name = "handle";
    }
    detected.detection.obstacles = std::move(obstacles);
    detected.kept = scene.cloud.size();
    return detected;
  }

 private:
  /// Of the first object.
  std::vector<grasp::Grasp> Grasps(const perception::Scene& scene,
                                   std::span<const geometry::TriangleMesh> obstacles_C,
                                   std::string& why_none) const {
    if (options_.take == TakeKind::kHandle) {
      auto by_handle = PlanHandleGrasps(scene, 0, robot_.hand(), options_.grasp, obstacles_C);
      why_none = std::move(by_handle.why_none);
      return std::move(by_handle.grasps);
    }
    const Eigen::Vector3d arm_W = robot_.links().front().X_PB.translation();
    return grasp::PlanGrasps(scene, 0, robot_.hand(), arm_W, options_.grasp, obstacles_C);
  }

  const Options& options_;
  const robot::Robot& robot_;
  SceneObserver observer_;
};

}  // namespace

geometry::Points PlacesOf(const geometry::Observation& observation) {
  geometry::Points places_C;
  for (const auto& view : observation.views) places_C.push_back(view.X_CV.translation());
  return places_C;
}

std::unique_ptr<Detector> MakeDetector(const Options& options, const robot::Robot& robot,
                                       SceneObserver observer) {
  if (!options.outside.command.empty()) {
    return MakeOutsideDetector(options, robot, std::move(observer));
  }
  switch (options.detector) {
    case DetectorKind::kDissertation:
      break;
  }
  return std::make_unique<DissertationDetector>(options, robot, std::move(observer));
}

}  // namespace rangegrasp::tasks::grasping
