#pragma once

namespace CLI {
class App;
}

namespace rangegrasp::cli {

/// `list`: what there is: kinds of experiments, and the keys of their files.
void AddListCommand(CLI::App& app);

}  // namespace rangegrasp::cli
