#pragma once

#include <span>

#include "geometry/mesh.h"
#include "grasp/detector.h"
#include "perception/scene.h"
#include "robot/robot.h"

namespace rangegrasp::parts {

/// Gives the first object back what perception may have cut off along the crease round it: small
/// objects next to it become parts of it. In clutter that may be a neighbor, too.
void JoinCutOffHandle(perception::Scene& scene);

/// Grasps of a perceived object by its handle: its measured points are segmented
/// (`hierarchy`), and the largest part that is thin, stands out of the body and is joined to it is
/// the handle (function/description.h).
/// @param object  position in scene.objects
/// @param obstacles_C  what the hand must not touch besides the other objects
grasp::SelectedGrasps PlanHandleGrasps(const perception::Scene& scene, std::size_t object,
                                       const robot::HandModel& hand,
                                       const grasp::GraspOptions& options,
                                       std::span<const geometry::TriangleMesh> obstacles_C);

}  // namespace rangegrasp::parts
