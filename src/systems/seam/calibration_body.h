#pragma once

#include <span>
#include <vector>

#include "seam/calibration.h"
#include "seam/profile.h"

namespace rangegrasp::seam {

/// The defined calibration object: a staircase, symmetric about x = 0, with its steps' heights
/// above its base and a common width; left of it and right of it the base.
struct CalibrationBody {
  std::vector<double> step_heights_m = {0.0, 0.002, 0.005, 0.009, 0.005, 0.002, 0.0};
  double step_width_m = 0.008;
};
/// A scan of the body with its base at a known height of frame L.
struct CalibrationScan {
  RawProfile profile;
  double base_height_m = 0.0;
};

/// The look-up table of scans from several distances, and its fit: finds each plateau of the
/// staircase (its row: a median) and each riser (its column) in every scan. Rows may rise or fall
/// with height. Steps must be 16 columns wide or more.
/// @throws base::InputError naming the scan in which the staircase is not found, and as
/// FitCalibration.
Calibration CalibrateFromBody(const CalibrationBody& body, std::span<const CalibrationScan> scans);

}  // namespace rangegrasp::seam
