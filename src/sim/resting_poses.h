#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "sim/world.h"

namespace rangegrasp::sim {

/// A face that an object rests on.
struct RestingFace {
  Eigen::Quaterniond R_WO;  ///< any yaw about z keeps it
  double height_m = 0.0;    ///< of the body's origin above the plane
};
/// A way an object can rest on a plane.
struct RestingPose {
  std::vector<RestingFace> faces;  ///< that count as one: the lowest first
  /// Quasi-static, by the solid angle of the hull faces seen from the center of mass: what a body
  /// set down without a bounce ends in. A body that is dropped ends in low poses more often.
  double probability = 0.0;
  double tipping_rad = 0.0;  ///< minimum tilt that tips it over
  std::string label;         ///< "pose0", ... by descending probability
};

/// Stable resting poses from the convex hull of the collision geometry and the center of mass
/// (Goldberg et al. 1999, part pose statistics): hull faces that hold the center's foot inside by
/// tipping_rad >= min_tipping_rad. Faces that the object's symmetry maps onto each other are one
/// pose, and so are those over which something round rolls.
/// @throws base::InputError naming the file if it is no object.
std::vector<RestingPose> StableRestingPoses(const ObjectModel& object,
                                            double min_tipping_rad = 0.15);

struct AtRest {
  const RestingPose* pose;
  const RestingFace* face;
};
/// The pose and the face of it on which an object rests that is turned so, within 5 deg; nullopt if
/// it is none of them.
std::optional<AtRest> FaceAtRest(const std::vector<RestingPose>& poses,
                                 const Eigen::Matrix3d& R_WO);

}  // namespace rangegrasp::sim
