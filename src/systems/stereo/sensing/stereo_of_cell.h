#pragma once

#include <filesystem>
#include <memory>

#include "base/yaml_map.h"
#include "stereo/reconstruct_options.h"
#include "stereo/sensing/stereo_sensor.h"
#include "trial/cell.h"

namespace rangegrasp::stereo {

/// The keys below `stereo` of grasping experiments.
struct Keys {
  ReconstructOptions reconstruct;  ///< from a pair of pictures to a cloud
  /// Of the camera; if empty, it is calibrated before the first trial.
  std::filesystem::path calibration;
};
/// Under this name they stand in trial::Options.
inline constexpr const char* kKeys = "stereo";
/// To the end of the map. @throws base::InputError
void ReadKeys(base::YamlMap map, Keys& keys);

/// The types of sensor files that hold a stereo camera.
inline constexpr const char* kStereoCamera = "stereo_camera";
inline constexpr const char* kLaserAndStereo = "laser_and_stereo";

/// The files that a sensor of both kinds names as `laser` and `stereo`.
struct BothFiles {
  std::filesystem::path laser, stereo;
};
/// @throws base::InputError naming the file.
BothFiles ReadBoth(const std::filesystem::path& sensor_file);

/// The file of an experiment's stereo camera; empty if it has none.
std::filesystem::path CameraFileOf(const trial::Options& options);

/// The stereo camera of a cell. @param camera  its file
std::unique_ptr<trial::StereoSensor> StereoOf(const trial::Cell& cell,
                                              const std::filesystem::path& camera);

}  // namespace rangegrasp::stereo
