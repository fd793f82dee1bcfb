#pragma once

namespace CLI {
class App;
}

namespace rangegrasp::cli {

void AddBringCommand(CLI::App& app);      ///< bring
void AddLearnCommand(CLI::App& app);      ///< learn
void AddRecognizeCommand(CLI::App& app);  ///< recognize

}  // namespace rangegrasp::cli
