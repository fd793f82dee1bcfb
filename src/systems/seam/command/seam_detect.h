#pragma once

#include <CLI/CLI.hpp>

#include "seam/profile_format.h"

namespace rangegrasp::cli {

/// Unit of camera rows in a text.
inline constexpr double kRowUnit = 1.0;
/// File options for camera rows: no unit, any row; images have 64 grey levels per row.
seam::ProfileFileOptions RowFileOptions();

/// Adds `seam detect`: detects edges in recorded or streamed profiles.
void AddSeamDetect(CLI::App& seam);

}  // namespace rangegrasp::cli
