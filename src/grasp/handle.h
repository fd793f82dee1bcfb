#pragma once

#include <vector>

#include "geometry/point_cloud.h"
#include "grasp/proposals.h"

namespace rangegrasp::grasp {

/// A part that stands out of an object, as a mug's handle, by its measured points.
struct Handle {
  geometry::PointSpan points_C;
  Eigen::Vector3d body_C;  ///< the middle of what it is joined to
};

struct HandleOptions {
  /// Gripped is what lies within this of the handle's outermost place: a bar and what bends away
  /// from it.
  double bar_m = 0.012;
  /// Points of one side only measure less than the bar; thinner is no handle for a person's hand.
  double min_width_m = 0.008;
  double step_rad = 0.2618;      ///< between approaches: 15 deg
  double max_rise_rad = 0.1745;  ///< the hand comes from above or level, to 10 deg
};

/// Ways to take a handle: the fingers close across the plane that it lies in (its least principal
/// axis), about what is farthest from the body, and come in that plane, the steepest first, thumb
/// and fingers either way.
/// @param up_C  the table's normal
/// @return none of fewer than three points.
std::vector<Proposal> ProposeHandleGrasps(const Handle& handle, const Eigen::Vector3d& up_C,
                                          const HandleOptions& options = {});

}  // namespace rangegrasp::grasp
