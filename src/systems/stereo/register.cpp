#include "cli/commands.h"
#include "sensing/line_scanner_options.h"
#include "stereo/command/stereo_commands.h"
#include "stereo/sensing/laser_and_stereo.h"
#include "stereo/sensing/stereo_of_cell.h"
#include "trial/registry.h"

namespace rangegrasp {
namespace {

namespace fs = std::filesystem;

fs::path NoLaser(const fs::path&) { return {}; }
fs::path LaserOf(const fs::path& file) { return stereo::ReadBoth(file).laser; }

void ReadKeys(base::YamlMap& map, trial::Options& options) {
  stereo::ReadKeys(map.Child("stereo", "from a pair of pictures to a cloud"),
                   trial::Of<stereo::Keys>(options, stereo::kKeys));
}

}  // namespace

void RegisterStereo() {
  trial::AddSensor({.word = stereo::kStereoCamera,
                    .states_noise = true,
                    .laser = NoLaser,
                    .files = [](const fs::path&) { return std::vector<fs::path>(); },
                    .make =
                        [](const trial::Cell& cell) {
                          return std::unique_ptr<trial::Sensor>(
                              stereo::StereoOf(cell, cell.options.sensor));
                        }});
  trial::AddSensor({.word = stereo::kLaserAndStereo,
                    .laser = LaserOf,
                    .files =
                        [](const fs::path& file) {
                          const stereo::BothFiles both = stereo::ReadBoth(file);
                          return std::vector<fs::path>{both.laser, both.stereo};
                        },
                    .make = [](const trial::Cell& cell) -> std::unique_ptr<trial::Sensor> {
                      return trial::MakeLaserAndStereo(
                          trial::MakeLineScanner(cell.scanner, cell.robot.X_WScanner),
                          stereo::StereoOf(cell, stereo::ReadBoth(cell.options.sensor).stereo));
                    }});
  trial::AddKeyReader(ReadKeys);
  cli::AddLibrary("opencv", RANGEGRASP_OPENCV_VERSION);
  cli::AddCommand(cli::AddStereoCommand);
  cli::AddCommand(cli::AddCalibrateHandEyeCommand);
  cli::AddCommand(cli::AddCalibrateStereoCommand);
}

}  // namespace rangegrasp
