#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "base/frames.h"
#include "geometry/mesh.h"
#include "geometry/observation.h"
#include "geometry/plane.h"
#include "grasp/grasp.h"
#include "grasp/obstacles.h"
#include "perception/scene.h"

/// What a detector hands over, whether it is the dissertation's method or any other program: plain
/// values, from which motions are planned and by which detection is scored. Nothing in it is truth.
/// C is the observation's frame (in a trial W).
namespace rangegrasp::grasp {

struct DetectedObject {
  std::vector<geometry::SampleId> samples;  ///< those that belong to it
  geometry::TriangleMesh surface_C;         ///< completed; may be empty
  bool rotational = false;
  bool open = false;  ///< a container
  /// The samples are meant to be all of it; false: those between the fingers of a grasp, of a
  /// detector that names no objects.
  bool whole = true;
};

struct DetectedGrasp {
  std::size_t object = 0;                    ///< position in Detection::objects
  base::Pose X_CH = base::Pose::Identity();  ///< the hand's root body
  double opening_m = 0.0;                    ///< gap of the pads before closing
  double width_m = 0.0;                      ///< what the pads are expected to close on
  /// By how much the faces that are gripped lean away from facing each other; 0 if not known.
  double contact_angle_rad = 0.0;
  Eigen::Vector3d approach_C{0.0, 0.0, -1.0};  ///< unit: the way of the hand towards the object
  double score = 0.0;                          ///< higher is better, within a type
  GraspType type = GraspType::kPower;
  double pitch_rad = 0.0;
  bool collides = false;  ///< the detector's own verdict; such a grasp counts but is not tried
  std::string name;       ///< of a known object's own grasp; else empty
};

struct Detection {
  geometry::Plane table_C;              ///< normal away from the table; z = 0 where none was found
  std::vector<DetectedObject> objects;  ///< in the order in which they should be taken
  std::vector<DetectedGrasp> grasps;    ///< best first
  Obstacles obstacles;                  ///< what else a motion should keep clear of
};

/// What the dissertation's method hands over.
/// @param grasps  of one object, best first (PlanGrasps)
/// @param object  position in scene.objects; its grasps take it along
Detection DetectionFrom(const perception::Scene& scene, std::span<const Grasp> grasps,
                        std::size_t object = 0);

}  // namespace rangegrasp::grasp
