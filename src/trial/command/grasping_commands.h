#pragma once

namespace CLI {
class App;
}  // namespace CLI

namespace rangegrasp::cli {

void AddCheckCommand(CLI::App& app);     ///< check
void AddPictureCommands(CLI::App& app);  ///< snapshot, scan

}  // namespace rangegrasp::cli
