#pragma once

#include <string>

#include "core/frames.h"
#include "core/yaml_map.h"
#include "stereo/camera.h"

namespace rangegrasp::stereo::internal {

/// A camera and a pose (x_mm, y_mm, z_mm and a unit quaternion) as calibration files hold them.
/// Readers read to the end of their mapping. @throws core::InputError naming file, line and key.
void ReadCamera(core::YamlMap& map, Camera& camera);
/// @param of  whose pose in which frame, for the keys' documentation.
core::Pose ReadPose(core::YamlMap& map, const std::string& of);

/// A mapping `name:` that the readers read, every digit kept.
std::string CameraText(const std::string& name, const Camera& camera);
std::string PoseText(const std::string& name, const core::Pose& pose);

}  // namespace rangegrasp::stereo::internal
