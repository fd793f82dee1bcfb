#pragma once

namespace CLI {
class App;
}

namespace rangegrasp::cli {

void AddExportCommand(CLI::App& app);     ///< export
void AddReproduceCommand(CLI::App& app);  ///< reproduce

}  // namespace rangegrasp::cli
