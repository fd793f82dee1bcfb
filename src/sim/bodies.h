#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "base/frames.h"
#include "geometry/mesh.h"
#include "geometry/ray_caster.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// The visible geoms of a body that have one color.
struct VisualBody {
  int body = 0;  ///< number in World::model()
  std::string name;
  geometry::TriangleMesh mesh_B;
  Eigen::Vector4f color;  ///< red, green, blue, opacity; mean color for a textured geom
  bool object = false;    ///< one of the world's objects
};

/// The visible geoms of all bodies. Unlike World::VisualMeshes, this includes the scanner and keeps
/// bodies apart, so that a web page can move them. Parked objects and infinite planes are left out.
std::vector<VisualBody> VisualBodies(const World& world);

base::Pose BodyPose(const World& world, int body);  ///< X_WB at the last kinematics update

/// Force of the hand at a contact.
struct ContactForce {
  Eigen::Vector3d point_W;
  Eigen::Vector3d force_W;  ///< [N], on the touched body
};
/// The contacts of the hand with a force above min_N in the last step.
/// @throws base::InputError if the scene has no body "hand".
std::vector<ContactForce> HandForces(const World& world, double min_N);

/// Visible surface and colors of an object in the frame B of its root body: World::ObjectPose.
/// @throws base::InputError naming the file if it is not an object.
geometry::ColoredMesh ObjectSurface(const ObjectModel& object);

}  // namespace rangegrasp::sim
