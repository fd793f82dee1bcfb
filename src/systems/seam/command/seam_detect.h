#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "seam/profile_format.h"

namespace rangegrasp::cli {

/// How a file of camera rows is read and written: no unit, any row; images: 64 grey levels a row.
seam::ProfileFileOptions RowFileOptions();

/// Adds `seam detect`: edges in profiles, recorded or streamed.
void AddSeamDetect(CLI::App& seam);

/// The page of the keys below `file` and of the presets.
std::string ProfileKeysPage();
/// Those keys, for `list formats --json`.
std::vector<ListEntry> ProfileKeys();

}  // namespace rangegrasp::cli
