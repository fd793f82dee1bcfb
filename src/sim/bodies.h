#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "base/frames.h"
#include "geometry/mesh.h"
#include "geometry/ray_caster.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// What a picture shows of a body in one colour.
struct VisualBody {
  int body = 0;  ///< number in World::model()
  std::string name;
  geometry::TriangleMesh mesh_B;
  Eigen::Vector4f color;  ///< red, green, blue, opacity; of what is printed on it, the mean
  bool object = false;    ///< one of the world's objects
};

/// The visible geoms of all bodies, as World::VisualMeshes, but with the scanner and one by one, so
/// that a page can move them. Parked objects and infinite planes are left out.
std::vector<VisualBody> VisualBodies(const World& world);

base::Pose BodyPose(const World& world, int body);  ///< X_WB as of the last kinematics

/// What the hand presses with at a contact.
struct ContactForce {
  Eigen::Vector3d point_W;
  Eigen::Vector3d force_W;  ///< [N], on what is touched
};
/// The contacts of the hand that bear more than min_N, as of the last step.
/// @throws base::InputError if the scene has no body "hand".
std::vector<ContactForce> HandForces(const World& world, double min_N);

/// What is seen of an object with its colors, in the frame B of its root body: World::ObjectPose.
/// @throws base::InputError naming the file if it is no object.
geometry::ColoredMesh ObjectSurface(const ObjectModel& object);

}  // namespace rangegrasp::sim
