#pragma once

#include "base/image/image.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// An object on the shipped table, in the pose that it rests in most likely, seen from near by.
/// @param camera  of the scene or a free view; empty: near by
/// @throws base::InputError naming the file if it is no object.
image::Image DrawObject(const sim::ObjectModel& object, const std::string& camera, int width,
                        int height);

}  // namespace rangegrasp::sim
