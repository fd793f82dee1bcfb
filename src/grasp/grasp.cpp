#include "grasp/grasp.h"

#include <algorithm>
#include <stdexcept>

#include "grasp/internal/candidates.h"

namespace rangegrasp::grasp {
namespace {

using internal::Candidate;
using internal::Quota;
using internal::Task;

constexpr std::size_t kSamples = 10000;  // neighbours about 2 mm apart on objects of this size
constexpr std::size_t kThinned = 5;      // every such sample where extents are enough

geometry::TriangleMesh SurfaceOf(const perception::PerceivedObject& object) {
  if (!object.surface_C.triangles.empty()) return object.surface_C;
  return SpeckMesh(object.completed_C, 0.002);
}

std::vector<geometry::TriangleMesh> Others(const perception::Scene& scene, std::size_t own) {
  std::vector<geometry::TriangleMesh> surfaces;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (i != own) surfaces.push_back(SurfaceOf(scene.objects[i]));
  }
  return surfaces;
}

SurfaceSamples Thinned(const SurfaceSamples& samples) {
  SurfaceSamples thin;
  const std::size_t step = samples.points.size() > kSamples / kThinned ? kThinned : 1;
  thin.area_m2 = samples.area_m2 * static_cast<double>(step);
  for (std::size_t i = 0; i < samples.points.size(); i += step) {
    thin.points.push_back(samples.points[i]);
    thin.normals.push_back(samples.normals[i]);
  }
  return thin;
}

Task MakeTask(const perception::Scene& scene, std::size_t index, const robot::HandModel& hand,
              const Eigen::Vector3d& arm_C, const GraspOptions& options) {
  const perception::PerceivedObject& object = scene.objects[index];
  SurfaceSamples samples = SampleObject(scene, object, kSamples);
  SurfaceSamples coarse = Thinned(samples);
  const Eigen::Vector3d com = CenterOfMass(object.surface_C, coarse);
  const Eigen::Vector3d& up = scene.table.plane.normal;
  return Task{scene,
              object,
              hand,
              arm_C,
              up,
              options,
              std::move(samples),
              std::move(coarse),
              com,
              HandProfiles(hand)};
}

/// Free grasps by type, in the order of section 5.2, and those that collide.
struct Collected {
  std::vector<Grasp> free;
  std::vector<Grasp> colliding;
};

void CollectRotational(Task& task, HandCollider& collider, int most, Collected& out) {
  const int shared = std::max(1, most / 6);
  internal::Judge(collider, task.hand, internal::CylindricalCandidates(task),
                  {most - 2 * shared, 1, 120}, out.free, out.colliding);
  if (task.object.open) collider.SetOwn(SpeckMesh(task.object.completed_C, 0.003));
  internal::Judge(collider, task.hand, internal::RimCandidates(task), {shared, 1, 60}, out.free,
                  out.colliding);
  if (task.object.open) collider.SetOwn(SurfaceOf(task.object));
}

}  // namespace

const char* Name(GraspType type) {
  switch (type) {
    case GraspType::kCylindrical:
      return "cylindrical";
    case GraspType::kRim:
      return "rim";
    case GraspType::kPower:
      return "power";
  }
  return "";
}

std::vector<Grasp> PlanGrasps(const perception::Scene& scene, std::size_t object,
                              const robot::HandModel& hand, const Eigen::Vector3d& arm_C,
                              const GraspOptions& options) {
  if (object >= scene.objects.size()) throw std::invalid_argument("PlanGrasps: no such object");
  if (options.most < 1) throw std::invalid_argument("PlanGrasps: most must be at least 1");
  Task task = MakeTask(scene, object, hand, arm_C, options);
  if (task.samples.points.empty()) return {};
  HandCollider collider(hand, Others(scene, object), SurfaceOf(task.object), scene.table.plane,
                        options.object_clearance_m, options.table_clearance_m);
  Collected out;
  const bool rotational = task.object.kind == perception::ObjectKind::kRotational;
  if (rotational) CollectRotational(task, collider, options.most, out);
  // The power grasp is for all other objects, and the last resort where a rotational one can be
  // held neither round its body nor by its rim.
  if (!rotational || out.free.empty()) {
    internal::Judge(collider, hand, internal::PowerCandidates(task), {options.most, 4, 120},
                    out.free, out.colliding);
  }
  std::vector<Grasp> grasps = std::move(out.free);
  grasps.insert(grasps.end(), out.colliding.begin(), out.colliding.end());
  if (grasps.size() > static_cast<std::size_t>(options.most)) {
    grasps.resize(static_cast<std::size_t>(options.most));
  }
  return grasps;
}

}  // namespace rangegrasp::grasp
