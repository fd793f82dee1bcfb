#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "seam/profile.h"

namespace rangegrasp::seam {

/// Non-linear mapping from a sensor's pixels to lengths (dissertation, section 3.2): a 4th-order
/// polynomial from row to height, and a column width that grows with the distance.
struct Calibration {
  int columns = 1024;
  double row_min_px = 0.0;                    ///< first calibrated row
  double row_max_px = 1023.0;                 ///< last calibrated row, > row_min_px
  std::array<double, 5> height_m{};           ///< of u^0..u^4; u is the row mapped to [-1, 1]
  std::array<double, 2> meters_per_column{};  ///< at height 0, and its change per metre of height
  double residual_m = 0.0;                    ///< rms error of the fitted heights; not in the file

  /// Height of a row [m]. NaN if the row is NaN or outside [row_min_px, row_max_px].
  double HeightAt(double row_px) const;
  /// x of a column in the line's frame L [m].
  double LateralAt(double column, double height) const;
};

/// One entry of the look-up table: a known height and the image row where it appeared.
struct HeightSample {
  double row_px, height_m;
};
/// A known point of the body and the column where it appeared.
struct LateralSample {
  double column, height_m, x_m;
};

/// All samples must be finite.
/// @throws base::InputError if there are fewer than 5 distinct rows or 3 lateral samples at 2
/// heights, columns do not increase with x, or the function is not monotonic over the rows (a real
/// sensor's is).
Calibration FitCalibration(std::span<const HeightSample> heights,
                           std::span<const LateralSample> laterals, int columns);

/// Applies a calibration. @throws base::InputError if the number of columns differs.
Profile Calibrate(const RawProfile& raw, const Calibration& calibration);

/// YAML.
/// @throws base::InputError naming file, line and key; base::RunError if it cannot be written.
Calibration ReadCalibration(const std::filesystem::path& file);
void WriteCalibration(const Calibration& calibration, const std::filesystem::path& file);

/// The calibration object: a staircase, symmetric about x = 0, on a base that continues beyond it.
struct CalibrationBody {
  std::vector<double> step_heights_m = {0.0, 0.002, 0.005, 0.009, 0.005, 0.002, 0.0};
  double step_width_m = 0.008;  ///< of each
};
/// A scan of the body with its base at a known height in frame L.
struct CalibrationScan {
  RawProfile profile;
  double base_height_m = 0.0;
};

/// Fits the look-up table of at least one scan, all of one width: the row of each plateau (a
/// median) and the column of each riser. Steps must be at least 16 columns wide.
/// @throws base::InputError naming a scan without the staircase, and like FitCalibration.
Calibration CalibrateFromBody(const CalibrationBody& body, std::span<const CalibrationScan> scans);

}  // namespace rangegrasp::seam
