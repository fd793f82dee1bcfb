#pragma once

#include <span>

#include "geometry/mesh.h"
#include "grasp/detector.h"
#include "perception/scene.h"
#include "robot/robot.h"

namespace rangegrasp::parts {

/// Merges small objects next to the first object into it, since perception may have cut off its
/// handle along the crease around it. In clutter this may also merge a neighbor.
void JoinCutOffHandle(perception::Scene& scene);

/// Plans grasps of a perceived object by its handle. The measured points of the object are
/// segmented (`hierarchy`). The handle is the largest part that is thin and protrudes from the body
/// (function/description.h).
/// @param object  index in scene.objects
/// @param obstacles_C  obstacles for the hand in addition to the other objects
grasp::SelectedGrasps PlanHandleGrasps(const perception::Scene& scene, std::size_t object,
                                       const robot::HandModel& hand,
                                       const grasp::GraspOptions& options,
                                       std::span<const geometry::TriangleMesh> obstacles_C);

}  // namespace rangegrasp::parts
