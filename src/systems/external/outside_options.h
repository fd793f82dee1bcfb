#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/yaml_map.h"

namespace rangegrasp::external {

/// A detector that is another program; empty command: there is none.
struct OutsideOptions {
  std::vector<std::string> command;          ///< the program's file, and its arguments
  std::vector<std::filesystem::path> files;  ///< those and folders that the command names as such
  double limit_s = 20.0;                     ///< from its start to its answer
  bool sandbox = false;
  int memory_mb = 4096;  ///< address space of each of its processes; 0: no limit
  int file_mb = 256;     ///< of each file that it writes; 0: no limit
  std::vector<std::filesystem::path> hidden;  ///< from a program in a sandbox: results lie there
};

/// Under this name they stand in trial::Options.
inline constexpr const char* kExternal = "external";

/// Reads the keys below `detector`, to the end of the map: words of the command that name a file
/// from the experiment's folder become its path, the program's name is looked for in PATH.
/// @throws base::InputError also if the program is not there.
void ReadOutside(base::YamlMap map, OutsideOptions& options);

}  // namespace rangegrasp::external
