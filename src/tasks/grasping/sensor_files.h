#pragma once

#include <filesystem>

#include "tasks/grasping/options.h"

namespace rangegrasp::tasks::grasping {

/// What a sensor's file is of, and the files that say how its parts are: itself, or those that a
/// sensor of both names as `laser` and `stereo`. Empty: there is no such part.
struct SensorFiles {
  SensorKind kind = SensorKind::kLineScanner;
  std::filesystem::path laser;
  std::filesystem::path stereo;
};
/// A line scanner's file need not say what it is. @throws core::InputError naming the file.
SensorFiles ReadSensorFiles(const std::filesystem::path& file);

}  // namespace rangegrasp::tasks::grasping
