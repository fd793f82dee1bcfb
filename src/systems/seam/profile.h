#pragma once

#include <array>
#include <vector>

namespace rangegrasp::seam {

/// A line with fewer columns is refused: windows of the filters and detectors need some tens.
constexpr int kMinColumns = 32;

/// How a stripe sensor's columns lie along its laser line.
/// Frame L of a line: x along the line (column numbers ascend with x), z up towards the sensor,
/// origin in the middle of the line at the height the sensor is mounted for.
struct LineGeometry {
  int columns = 1024;             ///< >= kMinColumns
  double columns_per_m = 12'000;  ///< > 0, at height 0; 12 px a mm (dissertation, section 3.6.4)

  double CenterColumn() const { return 0.5 * (columns - 1); }
  double ToMeters(double column) const { return (column - CenterColumn()) / columns_per_m; }
};

/// What the camera saw of one line: for each column the row of the brightest pixel [px], NaN where
/// there was none.
struct RawProfile {
  std::vector<float> row_px;
  double time_s = 0.0;
};

/// One line in metres: for each column the height [m], NaN where there is none.
struct Profile {
  std::vector<float> height_m;
  double time_s = 0.0;
  /// By how much the line moved along its x since the profile before, as the pose of its head tells
  /// [m]; 0 where no pose is known.
  double moved_m = 0.0;
};

}  // namespace rangegrasp::seam
