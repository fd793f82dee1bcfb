#pragma once

#include "base/yaml_map.h"
#include "sim/execute.h"
#include "sim/world.h"

namespace rangegrasp::sim {

/// Reads the keys of the mapping `physics`, to its end. @throws base::InputError
void ReadPhysicsOptions(base::YamlMap map, PhysicsOptions& options);

/// The same of `hand`, the hand's controller. @param firm_from_rad  receives firm_from_deg
void ReadHandOptions(base::YamlMap map, double& firm_from_rad, HandControlOptions& options);

}  // namespace rangegrasp::sim
