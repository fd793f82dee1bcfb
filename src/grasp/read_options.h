#pragma once

#include "base/yaml_map.h"
#include "grasp/detector.h"
#include "grasp/mover.h"

namespace rangegrasp::grasp {

/// Reads the keys of the mapping `grasp`, to its end. @throws base::InputError
void ReadGraspOptions(base::YamlMap map, DetectorOptions& options);

/// The same of `planning`: the mover's keys, and what it keeps clear of.
void ReadPlanningOptions(base::YamlMap map, planning::PlanOptions& options,
                         ObstacleOptions& obstacles);

}  // namespace rangegrasp::grasp
