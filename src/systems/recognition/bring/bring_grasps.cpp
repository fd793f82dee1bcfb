#include "recognition/bring/bring_grasps.h"

#include <algorithm>
#include <utility>

#include "grasp/view_obstacles.h"
#include "trial/objects.h"

namespace rangegrasp::bring {
namespace {

using grasp::Grasp;
using grasp::NamedGrasps;

/// Whether nobody's place is taken comes before everything but whether a grasp is free at all.
void KeepFree(const NamedGrasps& known, const base::Pose& X_CO, const robot::HandModel& hand,
              std::vector<Grasp>& grasps) {
  if (known.keep_free_O.empty()) return;
  std::ranges::stable_partition(grasps, [&](const Grasp& grasp) {
    return !grasp.collides && !grasp::TouchesKeptFree(grasp, known, X_CO, hand);
  });
}

}  // namespace

GraspsOf ReadGrasps(const Options& options) {
  GraspsOf grasps;
  for (const std::string& object : options.bring.known) {
    const auto mjcf = trial::ObjectModelOf(options.grasping, object).mjcf;
    grasps[object] = grasp::ReadNamedGrasps(mjcf.parent_path() / "grasps.yaml");
  }
  return grasps;
}

trial::Detected GraspsFor(const Understanding& understanding, std::size_t object,
                          const std::string& use, const geometry::Observation& observation,
                          const GraspsOf& grasps_of, const robot::Robot& robot,
                          const trial::Options& options) {
  perception::Scene scene = understanding.scene;
  const auto at = scene.objects.begin() + static_cast<std::ptrdiff_t>(object);
  std::rotate(scene.objects.begin(), at, at + 1);
  const auto obstacles = grasp::ObstaclesOfViews(scene, 0, observation, options.obstacles);
  const Eigen::Vector3d arm_W = robot.links().front().X_PB.translation();
  auto grasps =
      grasp::PlanGrasps(scene, 0, robot.hand(), arm_W, options.grasp, obstacles.measured_C);
  std::vector<std::string> names;
  if (const auto& found = understanding.found[object]) {
    const NamedGrasps& known = grasps_of.at(found->object);
    KeepFree(known, found->X_CB, robot.hand(), grasps);
    const auto named = grasp::PlaceNamedGrasps(known, use, found->X_CB, scene, 0, robot.hand(),
                                               options.grasp, obstacles.measured_C);
    for (const grasp::PlacedGrasp& placed : named) {
      grasps.insert(grasps.begin() + static_cast<std::ptrdiff_t>(names.size()), placed.grasp);
      names.push_back(known.grasps[placed.named].name);
    }
  }
  trial::Detected detected;
  detected.segments = static_cast<int>(scene.segments.size());
  detected.kept = scene.cloud.size();
  detected.detection = grasp::DetectionFrom(scene, grasps);
  detected.detection.obstacles = obstacles;
  for (std::size_t i = 0; i < names.size(); ++i) detected.detection.grasps[i].name = names[i];
  return detected;
}

}  // namespace rangegrasp::bring
