#pragma once

namespace CLI {
class App;
}

namespace rangegrasp::cli {

/// `run`: the cases of an experiment of any kind, into a store; prints its tables.
void AddRunCommand(CLI::App& app);

}  // namespace rangegrasp::cli
