#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "sim/world.h"

namespace rangegrasp::sim {

/// A way an object can rest on a plane.
struct RestingPose {
  Eigen::Quaterniond R_WO;  ///< one member of the class; any yaw about z keeps it
  double height_m = 0.0;    ///< of the body's origin above the plane
  /// Quasi-static, by the solid angle of the hull faces seen from the center of mass.
  double probability = 0.0;
  double tipping_rad = 0.0;  ///< minimum tilt that tips it over
  std::string label;         ///< "pose0", ... by descending probability
};

/// Stable resting poses from the convex hull of the collision geometry and the center of mass
/// (Goldberg et al. 1999, part pose statistics): hull faces that hold the center's foot inside by
/// tipping_rad >= min_tipping_rad; faces of one rolling or symmetric family (same height of the
/// center of mass, same tilt margins) are one class.
/// @throws core::InputError naming the file if it is no object.
std::vector<RestingPose> StableRestingPoses(const ObjectModel& object,
                                            double min_tipping_rad = 0.15);

}  // namespace rangegrasp::sim
