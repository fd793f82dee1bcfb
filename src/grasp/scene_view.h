#pragma once

#include "geometry/draw/canvas.h"
#include "grasp/grasp.h"

namespace rangegrasp::draw {

/// Perception and grasps of a cloud: table points are grey-blue, outliers red, every object has its
/// own color, rims are black, and each object's best free grasp is shown by the hand. If there is
/// one list, and all its grasps collide, the best one is shown in red.
/// @param points_C  the cloud that was perceived
/// @param grasps    one list per object, best first; may be shorter than the list of objects
Canvas DrawScene(geometry::PointSpan points_C, const perception::Scene& scene,
                 const std::vector<std::vector<grasp::Grasp>>& grasps,
                 const robot::HandModel& hand);

/// The hand with a gap between its pads.
geometry::TriangleMesh HandMesh(const robot::HandModel& hand, double gap_m, const base::Pose& X_CH);

/// A view of the objects of a scene, from the sensor's side and somewhat above.
View LookAtScene(const perception::Scene& scene, const Eigen::Vector3d& sensor_origin_C);
/// The same for any points on a table with the normal `up_C`.
View LookAtPoints(geometry::PointSpan points_C, const Eigen::Vector3d& up_C,
                  const Eigen::Vector3d& sensor_origin_C);

}  // namespace rangegrasp::draw
