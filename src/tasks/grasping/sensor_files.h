#pragma once

#include <array>
#include <filesystem>
#include <string_view>

namespace rangegrasp::tasks::grasping {

/// What looks at the settled objects: the `type` of the sensor's file.
enum class SensorKind { kLineScanner, kStereoCamera, kLaserAndStereo };
constexpr std::array<std::string_view, 3> WordsOf(SensorKind) {
  return {"line_scanner", "stereo_camera", "laser_and_stereo"};
}

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
