#pragma once

#include "geometry/mesh_colors.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// What is seen of an object (geoms of groups 0 to 2 that are not transparent) with its colors, in
/// the frame B of its root body, so that World::ObjectPose is its pose.
/// @throws base::InputError naming the file if it is no object.
geometry::ColoredMesh ObjectSurface(const ObjectModel& object);

}  // namespace rangegrasp::sim
