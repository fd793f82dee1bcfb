#pragma once

#include <CLI/CLI.hpp>

#include "seam/profile_io.h"

namespace rangegrasp::cli {

/// How a file of camera rows is read and written: no unit, any row; images: 64 grey levels a row.
seam::ProfileFileOptions RowFileOptions();

/// `seam generate`: simulated profiles, or scans of the calibration body.
void AddSeamGenerate(CLI::App& seam);
/// `seam calibrate`: scans of a calibration body to a calibration.
void AddSeamCalibrate(CLI::App& seam);

}  // namespace rangegrasp::cli
