#pragma once

#include <string>
#include <vector>

namespace rangegrasp::cli {

/// An option or a positional argument, as --help shows it.
struct OptionHelp {
  std::vector<std::string> flags;    ///< "-o", "--out"; empty for a positional argument
  std::string name;                  ///< of a positional argument, else empty
  std::string value;                 ///< what follows it, e.g. "TEXT"; empty for a flag
  std::vector<std::string> choices;  ///< all the values it takes; empty if it takes others
  std::string description, default_value;
  bool required = false;
};

/// A command, as --help shows it.
struct CommandHelp {
  std::string path;  ///< the words that call it, e.g. "seam track"; empty for the program itself
  std::string description, footer;
  std::vector<std::string> below;  ///< names of the commands one level below
  std::vector<OptionHelp> options;
};

/// The program and its commands, parents first, in the order of --help; without hidden ones.
using CommandTree = std::vector<CommandHelp>;

}  // namespace rangegrasp::cli
