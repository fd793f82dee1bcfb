#pragma once

#include "base/yaml_map.h"
#include "perception/perceive.h"

namespace rangegrasp::perception {

/// Reads the keys of the mapping `perception`, to its end. @throws base::InputError
void ReadOptions(base::YamlMap map, PerceptionOptions& options);

}  // namespace rangegrasp::perception
