#pragma once

namespace CLI {
class App;
}

namespace rangegrasp::cli {

void AddCylindersCommand(CLI::App& app);  ///< cylinders

}  // namespace rangegrasp::cli
