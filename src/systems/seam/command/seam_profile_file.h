#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "seam/monitor.h"
#include "seam/profile_format.h"
#include "seam/tracker.h"

namespace rangegrasp::cli {

/// How a file of camera rows is read and written: no unit, any row; images: 64 grey levels a row.
seam::ProfileFileOptions RowFileOptions();

/// Where profiles come from, and what a user says of their format.
struct ProfileFileArguments {
  std::string profiles;  ///< "-": stdin
  std::string options;   ///< YAML
  std::string preset;
  std::vector<std::string> words;  ///< KEY=VALUE each, of options of their own; over the file
  std::vector<std::string> set;    ///< KEY=VALUE each, over both
  bool calibrated = false;         ///< numbers are camera rows
};

/// What is done with them.
struct DetectOptions {
  seam::TrackerOptions tracker;  ///< by tracked steps, which miss the fewest edges (docs/seam.md)
  seam::MonitorOptions monitor;
  seam::ProfileFileOptions file;
  bool has_columns_per_mm = false;  ///< stated in the YAML
};

/// Adds --unit, the unit of the heights of a text.
CLI::Option* AddUnit(CLI::App& command, ProfileFileArguments& arguments);

/// Adds the options that tell the format, in groups of their own. Each is a short word for a key
/// below `file`.
void AddFormatOptions(CLI::App& command, ProfileFileArguments& arguments);

/// The preset's keys, over them those of the YAML file, over them --set.
/// @throws base::InputError naming the file, line and key, or keys that do not fit the file's kind.
DetectOptions ReadDetectOptions(const ProfileFileArguments& arguments);

/// The page of the keys below `file` and of the presets.
std::string ProfileKeysPage();

}  // namespace rangegrasp::cli
