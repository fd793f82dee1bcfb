#pragma once

#include <filesystem>
#include <string>

#include "base/frames.h"
#include "base/yaml_map.h"

namespace rangegrasp::sensing {

/// Pose of a sensor's head on the hand, and the accuracy of the pose.
struct HandEye {
  base::Pose X_HS = base::Pose::Identity();
  double shift_error_m = 0.0;
  double turn_error_rad = 0.0;
};

/// Reads and writes YAML.
/// @throws base::InputError naming file, line and key; base::RunError if writing fails.
HandEye ReadHandEye(const std::filesystem::path& file);
void WriteHandEye(const HandEye& hand_eye, const std::filesystem::path& file);

/// Reads a pose of a calibration file from the mapping under a required key: x_mm, y_mm, z_mm and a
/// unit quaternion.
/// @throws base::InputError naming file, line and key.
base::Pose ReadPoseOf(base::YamlMap& map, const std::string& key);
/// A mapping `name:` for ReadPoseOf, in full precision.
std::string PoseText(const std::string& name, const base::Pose& pose);

}  // namespace rangegrasp::sensing
