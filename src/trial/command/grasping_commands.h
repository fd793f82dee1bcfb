#pragma once

namespace CLI {
class App;
}

namespace rangegrasp::cli {

void AddCheckCommand(CLI::App& app);     ///< check
void AddPerceiveCommand(CLI::App& app);  ///< perceive
void AddPictureCommands(CLI::App& app);  ///< snapshot, scan

}  // namespace rangegrasp::cli
