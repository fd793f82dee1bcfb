#pragma once

namespace CLI {
class App;
}

namespace rangegrasp::cli {

void AddStereoCommand(CLI::App& app);            ///< stereo
void AddCalibrateStereoCommand(CLI::App& app);   ///< calibrate-stereo
void AddCalibrateHandEyeCommand(CLI::App& app);  ///< calibrate-hand-eye

}  // namespace rangegrasp::cli
