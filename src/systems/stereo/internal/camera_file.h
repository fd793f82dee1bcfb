#pragma once

#include <string>

#include "base/yaml_map.h"
#include "stereo/camera.h"

namespace rangegrasp::stereo::internal {

/// A camera as calibration files hold it, to the end of the mapping.
/// @throws base::InputError naming file, line and key.
void ReadCamera(base::YamlMap& map, Camera& camera);

/// A mapping `name:` that it reads, every digit kept.
std::string CameraText(const std::string& name, const Camera& camera);

}  // namespace rangegrasp::stereo::internal
