#include "grasp/detection.h"

namespace rangegrasp::grasp {
namespace {

DetectedObject ObjectFrom(const perception::Scene& scene,
                          const perception::PerceivedObject& object) {
  DetectedObject out;
  out.samples = scene.SamplesOf(object);
  out.surface_C = object.surface_C;
  out.rotational = object.kind == perception::ObjectKind::kRotational;
  out.open = object.open;
  return out;
}

DetectedGrasp GraspFrom(const Grasp& grasp, std::size_t object) {
  return {object,
          grasp.X_CH,
          grasp.opening_m,
          grasp.width_m,
          grasp.contact_angle_rad,
          grasp.X_CG.linear().col(2),
          grasp.score,
          grasp.type,
          grasp.pitch_rad,
          grasp.collides,
          {}};
}

}  // namespace

Detection DetectionFrom(const perception::Scene& scene, std::span<const Grasp> grasps,
                        std::size_t object) {
  Detection detection;
  detection.table_C = scene.table.plane;
  for (const perception::PerceivedObject& perceived : scene.objects) {
    detection.objects.push_back(ObjectFrom(scene, perceived));
  }
  for (const Grasp& grasp : grasps) detection.grasps.push_back(GraspFrom(grasp, object));
  return detection;
}

}  // namespace rangegrasp::grasp
