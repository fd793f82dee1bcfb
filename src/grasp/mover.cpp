#include "grasp/mover.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

namespace rangegrasp::grasp {
namespace {

// A grasp that is delivered more often than not is worth a bolder motion.
constexpr double kHolds = 0.5;

planning::PlanningScene SceneFrom(const Detection& detection) {
  planning::PlanningScene scene;
  const auto& plane = detection.table_C;
  scene.table_z_m = -plane.offset_m / plane.normal.z();
  scene.target_W = detection.objects.front().surface_C;
  for (std::size_t i = 1; i < detection.objects.size(); ++i) {
    scene.obstacles_W.push_back(detection.objects[i].surface_C);
  }
  const auto& measured = detection.obstacles.measured_C;
  scene.obstacles_W.insert(scene.obstacles_W.end(), measured.begin(), measured.end());
  return scene;
}

// The free grasps that are expected to hold, or the others. Without sound_first, all count as
// sound.
geometry::Indices FreeGrasps(const Detection& detection, bool sound, const MoverOptions& options,
                             double friction_cone_rad) {
  return geometry::PositionsWhere(detection.grasps, [&](const DetectedGrasp& grasp) {
    const bool holds =
        !options.sound_first || (grasp.probability ? *grasp.probability >= kHolds
                                                   : grasp.contact_angle_rad <= friction_cone_rad);
    return !grasp.collides && holds == sound;
  });
}

Move PlanFirst(planning::Planner& planner, const Detection& detection,
               std::span<const std::uint32_t> grasps, const Eigen::VectorXd& q_start,
               bool may_brush, int max_plans, base::Rng& rng) {
  Move move;
  std::map<std::string, int> failures;
  for (const auto i : grasps) {
    if (move.tried == max_plans) break;
    ++move.tried;
    const DetectedGrasp& grasp = detection.grasps[i];
    auto planned = planner.Plan({.q_start = q_start,
                                 .X_WH = grasp.X_CH,
                                 .approach_W = grasp.approach_C,
                                 .opening_m = grasp.opening_m,
                                 .closed_gap_m = grasp.width_m,
                                 .may_brush = may_brush},
                                rng);
    if (planned.plan) {
      move.plan = std::move(planned.plan);
      move.grasp = i;
      return move;
    }
    ++failures[std::string(base::Word(planned.failure)) +
               (planned.blocked_by.empty() ? "" : " (" + planned.blocked_by + ")")];
  }
  std::vector<std::pair<std::string, int>> ranked(failures.begin(), failures.end());
  std::ranges::stable_sort(ranked, std::greater{}, &std::pair<std::string, int>::second);
  for (const auto& [word, count] : ranked) {
    move.failures += fmt::format("{}{} x{}", move.failures.empty() ? "" : ", ", word, count);
  }
  return move;
}

}  // namespace

Move PlanMove(const Detection& detection, const Eigen::VectorXd& q_start,
              const MoverOptions& options, double friction_cone_rad, const robot::Robot& robot,
              base::Rng& rng) {
  const planning::PlanningScene seen = SceneFrom(detection);
  const auto& unseen = detection.obstacles.unseen_C;
  planning::PlanningScene all = seen;
  all.obstacles_W.insert(all.obstacles_W.end(), unseen.begin(), unseen.end());
  planning::Planner planner(robot, options.planning);
  Move move;
  for (const bool sound : {true, false}) {
    const geometry::Indices grasps = FreeGrasps(detection, sound, options, friction_cone_rad);
    const auto plan = [&](const planning::PlanningScene& scene, bool may_brush) {
      if (move.plan || grasps.empty()) return false;
      planner.SetScene(scene);
      const int tried = move.tried;
      move = PlanFirst(planner, detection, grasps, q_start, may_brush, options.max_plans, rng);
      move.tried += tried;
      return move.plan.has_value();
    };
    plan(all, false);
    if (options.through_unseen && !unseen.empty() && plan(seen, false)) move.blind = true;
    const auto& brushed = options.through_unseen ? seen : all;
    if (options.brushing && !seen.obstacles_W.empty() && plan(brushed, true)) {
      move.blind = options.through_unseen && !unseen.empty();
      move.brushes = true;
    }
  }
  return move;
}

void ReadPlanningOptions(base::YamlMap map, MoverOptions& options, ObstacleOptions& obstacles) {
  base::ReadAdditions<ObstacleAdditions>(map, obstacles);
  base::ReadAdditions<MoverAdditions>(map, options);
  planning::PlanOptions& plan = options.planning;
  map.ReadScaled("approach_mm", plan.approach_m, base::kMm, 20.0, 400.0,
                 "length of the straight approach before the grasp");
  map.ReadScaled("lift_mm", plan.lift_m, base::kMm, 100.0, 400.0, "height of the lift");
  map.Finish();
}

}  // namespace rangegrasp::grasp
