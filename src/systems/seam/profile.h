#pragma once

#include <array>
#include <span>
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

struct FilterOptions {
  int half_width_columns = 12;  ///< >= 1, of the rectangular window: 1 mm of the base sensor
  /// > 0; below the thinnest mat's 0.3 mm, so that the two sides of an edge do not bear each other
  /// out, and above the noise of a row.
  double half_height_m = 0.2e-3;
  int min_neighbors = 10;  ///< >= 0; Prepare scales it by a profile's share of points
};

struct PreprocessOptions {
  FilterOptions filter;
  bool normalise = true;
  int min_columns = 128;  ///< >= 8: an eighth of 1024
};

/// The geometric filter (dissertation, section 3.2): keeps a point if at least `min_neighbors`
/// others lie within the rectangular window round it. Linear in columns x window.
/// @return the heights, NaN where a point was dropped or missing.
std::vector<float> FilterGeometric(std::span<const float> height_m, const FilterOptions& options);

/// Least-squares parabola c0 + c1 u + c2 u^2 through the finite points, u = the column mapped to
/// [-1, 1]. Falls back to fewer terms where the points do not determine them (0 points: 0).
std::array<double, 3> FitQuadratic(std::span<const float> height_m);

/// Fills each hole: an inner one from its left and right neighbors with horizontal lines that meet
/// in its middle, an outer one with the height of the nearest point. No finite point: left as it
/// is.
void FillHoles(std::span<float> height_m);

/// A profile made ready for the detectors. The original heights stay, since normalising loses the
/// distance between sensor and mat.
struct PreparedProfile {
  std::vector<float> original_m;  ///< as measured, NaN where there was none
  std::vector<float> height_m;    ///< filtered, normalised, filled; empty if unusable
  std::array<double, 3> curve{};  ///< what was subtracted
  int points = 0;                 ///< that passed the filter
  int first_column = 0;           ///< of the first and last of them
  int last_column = 0;
  double time_s = 0.0;
  double moved_m = 0.0;  ///< Profile::moved_m

  bool Usable() const { return !height_m.empty(); }
};

/// Filter, normalisation, hole filling, in this order.
PreparedProfile Prepare(const Profile& profile, const PreprocessOptions& options);

}  // namespace rangegrasp::seam
