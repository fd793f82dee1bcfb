#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "seam/profile.h"

namespace rangegrasp::seam {

/// The non-linear relation between a sensor's pixels and lengths (dissertation, section 3.2): a
/// function of 4th order from row to height, and a column's width that grows with the distance.
struct Calibration {
  int columns = 1024;
  double row_min_px = 0.0;                    ///< rows that calibration has seen
  double row_max_px = 1023.0;                 ///< > row_min_px
  std::array<double, 5> height_m{};           ///< powers 0..4 of u = the row mapped to [-1, 1]
  std::array<double, 2> meters_per_column{};  ///< at height 0, and its change a metre of height

  /// Height of a row [m]; NaN for a row outside of [row_min_px, row_max_px] or NaN.
  double HeightAt(double row_px) const;
  /// x of a column in the line's frame L [m].
  double LateralAt(double column, double height) const;
};

/// One row of the look-up table: a known height and the row it appeared in.
struct HeightSample {
  double row_px;
  double height_m;
};
/// A known place on the body and the column it appeared in.
struct LateralSample {
  double column;
  double height_m;
  double x_m;
};

/// Fits the function of 4th order and the column width to a look-up table, by least squares.
/// @throws base::InputError for fewer than 32 columns, 5 distinct rows or 3 lateral samples at 2
/// heights, a sample that is not finite, columns that do not ascend with x, or a function that is
/// not monotone over the rows (no real sensor's).
Calibration FitCalibration(std::span<const HeightSample> heights,
                           std::span<const LateralSample> laterals, int columns);

/// Applies a calibration. @throws base::InputError if the number of columns differs.
Profile Calibrate(const RawProfile& raw, const Calibration& calibration);

/// YAML. @throws base::InputError naming file, line and key; base::RunError if it cannot be
/// written.
Calibration ReadCalibration(const std::filesystem::path& file);
void WriteCalibration(const Calibration& calibration, const std::filesystem::path& file);

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

/// The look-up table of scans from several distances, and its fit: each plateau of the staircase
/// (its row: a median) and each riser (its column) in every scan. Rows may rise or fall with
/// height. Steps must be 16 columns wide or more.
/// @throws base::InputError naming the scan in which the staircase is not found, and as
/// FitCalibration.
Calibration CalibrateFromBody(const CalibrationBody& body, std::span<const CalibrationScan> scans);

}  // namespace rangegrasp::seam
