#include "grasp/detector.h"

#include <algorithm>

#include "base/stopwatch.h"
#include "grasp/view_obstacles.h"
#include "grasp/workspace.h"
#include "perception/perceive.h"

namespace rangegrasp::grasp {
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
  DissertationDetector(const DetectorOptions& options, const robot::Robot& robot,
                       SceneObserver observer)
      : options_(options),
        robot_(robot),
        selector_(FindGraspSelector(options.take)),
        observer_(std::move(observer)) {}

  Detected Detect(const geometry::Observation& observation, base::Rng& rng,
                  const Turn& turn) const override {
    Detected detected;
    base::Stopwatch watch;
    perception::Scene scene = perception::Perceive(
        observation, options_.perception, rng, WorkspaceOf(robot_, options_.workspace_margin_m));
    detected.seconds.emplace_back("perceive", watch.Restart());
    for (const auto& [step, seconds] : scene.seconds) {
      detected.seconds.emplace_back("perceive: " + step, seconds);
    }
    detected.has_turn = PutFirst(turn, scene);
    Obstacles obstacles;
    std::vector<Grasp> grasps;
    if (selector_ && selector_->prepare) selector_->prepare(scene);
    if (detected.has_turn && !scene.objects.empty()) {
      obstacles = ObstaclesOfViews(scene, 0, observation, options_.obstacles);
      detected.seconds.emplace_back("obstacles", watch.Restart());
      grasps = Grasps(scene, obstacles.measured_C, detected.why_none);
      detected.seconds.emplace_back("grasp", watch.Restart());
    }
    if (observer_) observer_(scene, grasps, observation);
    detected.segments = static_cast<int>(scene.segments.size());
    detected.detection = DetectionFrom(scene, grasps);
    if (selector_) {
      for (DetectedGrasp& grasp : detected.detection.grasps) grasp.name = selector_->word;
    }
    detected.detection.obstacles = std::move(obstacles);
    detected.kept = scene.cloud.size();
    return detected;
  }

 private:
  /// Of the first object.
  std::vector<Grasp> Grasps(const perception::Scene& scene,
                            std::span<const geometry::TriangleMesh> obstacles_C,
                            std::string& why_none) const {
    if (selector_) {
      auto selected = selector_->plan(scene, 0, robot_.hand(), options_.grasp, obstacles_C);
      why_none = std::move(selected.why_none);
      return std::move(selected.grasps);
    }
    const Eigen::Vector3d arm_W = robot_.links().front().X_PB.translation();
    return PlanGrasps(scene, 0, robot_.hand(), arm_W, options_.grasp, obstacles_C);
  }

  const DetectorOptions& options_;
  const robot::Robot& robot_;
  const GraspSelector* selector_;  ///< null: anywhere
  SceneObserver observer_;
};

}  // namespace

geometry::Points PlacesOf(const geometry::Observation& observation) {
  geometry::Points places_C;
  for (const auto& view : observation.views) places_C.push_back(view.X_CV.translation());
  return places_C;
}

std::unique_ptr<Detector> MakeDissertationDetector(const DetectorOptions& options,
                                                   const robot::Robot& robot,
                                                   SceneObserver observer) {
  return std::make_unique<DissertationDetector>(options, robot, std::move(observer));
}

}  // namespace rangegrasp::grasp
