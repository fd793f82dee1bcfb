#pragma once

#include <cstddef>

#include "geometry/observation.h"
#include "grasp/obstacles.h"
#include "perception/scene.h"

namespace rangegrasp::grasp {

/// ObstaclesOf for all views of an observation. Of several, space is unseen if none of them
/// saw it (UnseenByAll).
/// @param target  position in scene.objects
Obstacles ObstaclesOfViews(const perception::Scene& scene, std::size_t target,
                           const geometry::Observation& observation,
                           const ObstacleOptions& options);

}  // namespace rangegrasp::grasp
