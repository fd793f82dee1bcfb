#pragma once

namespace CLI {
class App;
}

namespace rangegrasp::cli {

void AddSeamCommands(CLI::App& app);  ///< seam generate, calibrate, detect

}  // namespace rangegrasp::cli
