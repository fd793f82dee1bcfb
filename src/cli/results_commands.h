#pragma once

namespace CLI {
class App;
}

namespace rangegrasp::cli {

/// What is done with the results of `run`: `table`, `trial`, `compare`, `merge`.
void AddResultsCommands(CLI::App& app);

}  // namespace rangegrasp::cli
