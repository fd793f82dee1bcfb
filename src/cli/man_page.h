#pragma once

#include <string>

#include "cli/command_tree.h"

namespace rangegrasp::cli {

/// The manual page of the program and all its commands, in the language of man(7): what --help
/// says, in one page. `version` stands in its footer.
std::string ManPage(const CommandTree& tree, const std::string& version);

}  // namespace rangegrasp::cli
