#pragma once

#include <string>

#include "cli/command_tree.h"

namespace rangegrasp::cli {

/// A bash script that completes the program's commands, options, choices and names of experiments,
/// and files everywhere else.
std::string BashCompletion(const CommandTree& tree);

}  // namespace rangegrasp::cli
