#pragma once

namespace CLI {
class App;
}

namespace rangegrasp::cli {

void AddPartsCommands(CLI::App& app);  ///< parts FILE

}  // namespace rangegrasp::cli
