#include "grasp/grasp.h"

#include "grasp/internal/candidates.h"
#include "robot/ik.h"

namespace rangegrasp::grasp {
namespace {

using collision::HandCollider;
using Eigen::Vector3d;
using internal::Collected;
using internal::Task;
using perception::PerceivedObject;
using perception::Scene;
using robot::HandModel;

/// Samples of an object's surface: about 2 mm apart on a cup, as in a scan.
constexpr std::size_t kSamples = 10000;
/// Where extents suffice, one in this many samples is used: neighbors are about 4 mm apart.
constexpr std::size_t kThinned = 5;
/// Specks of a container's points, finer than a wall is thick (its surface closes the cavity).
constexpr double kWallSpeckCell_m = 0.003;

Task MakeTask(const Scene& scene, std::size_t index, const HandModel& hand, const Arm& arm,
              const GraspOptions& options) {
  const PerceivedObject& object = scene.objects[index];
  SurfaceSamples samples = SampleObject(scene, object, kSamples);
  const std::size_t step = samples.points.size() > kSamples / kThinned ? kThinned : 1;
  geometry::Points coarse;
  for (std::size_t i = 0; i < samples.points.size(); i += step) {
    coarse.push_back(samples.points[i]);
  }
  const Vector3d com = CenterOfMass(object.surface_C, coarse);
  return {scene,
          object,
          hand,
          arm,
          scene.table.plane.normal,
          options,
          std::move(samples),
          std::move(coarse),
          com,
          internal::HandProfiles(hand)};
}

bool Enough(const std::vector<Grasp>& free, const ChoosingOptions& choosing) {
  return std::ranges::count_if(free, [&](const Grasp& grasp) {
           return grasp.score >= choosing.enough_score;
         }) >= choosing.enough;
}

/// Contacts cannot be judged without normals.
bool HasNormals(const Scene& scene, const PerceivedObject& object) {
  return !object.surface_C.triangles.empty() || !scene.cloud.normals.empty();
}

void CollectRotational(Task& task, HandCollider& collider, Collected& out) {
  const ChoosingOptions& choosing = task.options.choosing;
  const int shared = std::max(1, task.options.max_candidates / choosing.rim_share);
  const int cylindrical = std::max(1, task.options.max_candidates - 2 * shared);
  internal::ChooseFree(collider, task, internal::CylindricalCandidates(task),
                       {cylindrical, 1, choosing.max_checks}, out);
  if (task.object.open) collider.SetOwn(SpeckMesh(task.object.completed_C, kWallSpeckCell_m));
  internal::ChooseFree(collider, task, internal::RimCandidates(task),
                       {shared, 1, choosing.max_rim_checks}, out);
  if (task.object.open) collider.SetOwn(SurfaceOf(task.object));
}

void CollectCrowded(Task& task, HandCollider& collider, Collected& out) {
  const GraspOptions& options = task.options;
  const std::size_t rounds = 1 + options.power.crowded_leans_rad.size();
  for (std::size_t round = 0; round < rounds && !Enough(out.free, options.choosing); ++round) {
    internal::ChooseFree(collider, task, internal::CrowdedCandidates(task, round),
                         {options.max_candidates, options.choosing.power_per_group,
                          options.choosing.max_crowded_checks},
                         out);
  }
  std::ranges::stable_sort(out.free, std::ranges::greater(), &Grasp::score);
}

void CollectFromAbove(Task& task, HandCollider& collider, Collected& out) {
  const GraspOptions& options = task.options;
  const bool rotational =
      task.object.kind == perception::ObjectKind::kRotational && !options.power_only;
  if (rotational) CollectRotational(task, collider, out);
  // Power grasps are for all other objects. They are the last resort for a rotational one that can
  // be held neither around its body nor by its rim.
  if (rotational && !(options.power_fallback && out.free.empty())) return;
  internal::ChooseFree(
      collider, task, internal::PowerCandidates(task),
      {options.max_candidates, options.choosing.power_per_group, options.choosing.max_checks}, out);
  if (options.crowded && HasNormals(task.scene, task.object)) CollectCrowded(task, collider, out);
}

}  // namespace

Arm::Arm(const robot::Robot& robot)
    : base_C(robot.links().front().X_PB.translation()), reaches([&robot](const base::Pose& X_CH) {
        base::Rng rng(0);  // the same answer for the same pose
        return !SolveIk(robot, X_CH, robot.home, {.max_solutions = 1}, rng).empty();
      }) {}

std::vector<Grasp> PlanGrasps(const Scene& scene, std::size_t object, const HandModel& hand,
                              const Arm& arm, const GraspOptions& given,
                              std::span<const geometry::TriangleMesh> obstacles_C) {
  GraspOptions options = given;
  options.pitches = options.pitches && !hand.level;  // a level hand is not pitched
  Task task = MakeTask(scene, object, hand, arm, options);
  if (task.samples.points.empty()) return {};
  HandCollider collider(hand, Others(scene, object, obstacles_C), SurfaceOf(task.object),
                        scene.table.plane, {options.object_clearance_m, options.table_clearance_m});
  Collected out;
  if (options.approach != ApproachKind::kSides) CollectFromAbove(task, collider, out);
  if (options.approach != ApproachKind::kAbove && HasNormals(scene, task.object) &&
      !Enough(out.free, options.choosing)) {
    // They come after those from above; their scores are not compared.
    internal::ChooseFree(collider, task, internal::LateralCandidates(task),
                         {options.max_candidates, options.choosing.power_per_group,
                          options.choosing.max_crowded_checks},
                         out);
  }
  std::vector<Grasp> grasps = std::move(out.free);
  grasps.insert(grasps.end(), out.unreachable.begin(), out.unreachable.end());
  grasps.insert(grasps.end(), out.colliding.begin(), out.colliding.end());
  const auto max = static_cast<std::size_t>(options.max_candidates);
  if (grasps.size() > max) grasps.resize(max);
  return grasps;
}

}  // namespace rangegrasp::grasp
