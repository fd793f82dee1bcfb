#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "sim/world.h"

namespace rangegrasp::sim {

/// A face that an object rests on.
struct RestingFace {
  Eigen::Quaterniond R_WO;  ///< any yaw about z is equivalent
  double height_m = 0.0;    ///< height of the body's origin above the plane
};
/// A way an object can rest on a plane.
struct RestingPose {
  std::vector<RestingFace> faces;  ///< faces that count as one pose, the lowest first
  /// Quasi-static probability from the solid angle of the hull faces, seen from the center of mass,
  /// for a body that is set down without a bounce. A dropped body ends in low poses more often.
  double probability = 0.0;
  double tipping_rad = 0.0;  ///< minimum tilt that tips it over
  std::string label;         ///< "pose0", ... by descending probability
};

/// Stable resting poses from the convex hull of the collision geometry and the center of mass
/// (Goldberg et al. 1999, part pose statistics): hull faces that contain the projected center, with
/// tipping_rad >= min_tipping_rad. Faces that the object's symmetry maps onto each other count as
/// one pose, and so do the faces over which a round object rolls.
/// @throws base::InputError naming the file if it is not an object.
std::vector<RestingPose> StableRestingPoses(const ObjectModel& object,
                                            double min_tipping_rad = 0.15);

struct AtRest {
  const RestingPose* pose;
  const RestingFace* face;
};
/// The pose, and its face, that an object with this orientation rests on, within 5 deg; nullopt if
/// there is none.
std::optional<AtRest> FaceAtRest(const std::vector<RestingPose>& poses,
                                 const Eigen::Matrix3d& R_WO);

}  // namespace rangegrasp::sim
