#pragma once

namespace CLI {
class App;
}

namespace rangegrasp::cli {

/// Each adds its commands to the program; a command's callback does the work and throws
/// core::InputError or core::RunError.
void AddPictureCommands(CLI::App& app);  ///< snapshot, scan
void AddPartsCommands(CLI::App& app);    ///< parts FILE
void AddPerceiveCommand(CLI::App& app);  ///< perceive
void AddSeamCommands(CLI::App& app);     ///< seam generate, calibrate, detect
void AddShellCommands(CLI::App& app);    ///< completion, man
void AddVersionCommand(CLI::App& app);   ///< version

}  // namespace rangegrasp::cli
