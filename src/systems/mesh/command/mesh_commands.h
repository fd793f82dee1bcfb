#pragma once

namespace CLI {
class App;
}

namespace rangegrasp::cli {

void AddAddObjectCommand(CLI::App& app);  ///< add-object

}  // namespace rangegrasp::cli
