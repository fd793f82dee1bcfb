#pragma once

#include <filesystem>
#include <string>

#include "base/frames.h"
#include "base/yaml_map.h"

namespace rangegrasp::sensing {

/// Where a sensor's head sits on the hand, and how well that is known.
struct HandEye {
  base::Pose X_HS = base::Pose::Identity();
  double shift_error_m = 0.0;
  double turn_error_rad = 0.0;
};

/// YAML. @throws base::InputError naming file, line and key; base::RunError if not written.
HandEye ReadHandEye(const std::filesystem::path& file);
void WriteHandEye(const HandEye& hand_eye, const std::filesystem::path& file);

/// A pose as calibration files hold it: x_mm, y_mm, z_mm and a unit quaternion, to the end of the
/// mapping.
/// @param of  whose pose in which frame, for the keys' documentation.
/// @throws base::InputError naming file, line and key.
base::Pose ReadPose(base::YamlMap& map, const std::string& of);
/// The same of the mapping under a key, which must be there.
base::Pose ReadPoseOf(base::YamlMap& map, const std::string& key, const std::string& of);
/// A mapping `name:` that ReadPose reads, every digit kept.
std::string PoseText(const std::string& name, const base::Pose& pose);

}  // namespace rangegrasp::sensing
