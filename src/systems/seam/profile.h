#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace rangegrasp::seam {

/// Lines with fewer columns are rejected: the windows of filters and detectors need a few tens.
constexpr int kMinColumns = 32;

/// Mapping from a stripe sensor's columns to positions along its laser line. Frame L of a line: x
/// ascends with the columns, z points to the sensor, the origin is in the middle of the line at the
/// height for which the sensor is mounted.
struct LineGeometry {
  int columns = 1024;             ///< >= kMinColumns
  double columns_per_m = 12'000;  ///< > 0, at height 0; 12 px per mm (dissertation, section 3.6.4)

  double CenterColumn() const { return 0.5 * (columns - 1); }
  double ToMeters(double column) const { return (column - CenterColumn()) / columns_per_m; }
};

/// Camera measurement of one line: row of each column's brightest pixel [px], NaN if there is none.
struct RawProfile {
  std::vector<float> row_px;
  double time_s = 0.0;
};

/// One line in metres: height of each column [m], NaN if there is none.
struct Profile {
  std::vector<float> height_m;
  double time_s = 0.0;
  double moved_m = 0.0;  ///< motion of the line along its x since the previous profile; 0: unknown
};

/// The part of a line from column `begin` to before `end`, without columns beyond its ends.
inline std::span<const float> Within(std::span<const float> line, long begin, long end) {
  const long first = std::clamp(begin, 0L, std::ssize(line));
  const long last = std::clamp(end, first, std::ssize(line));
  return line.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(last - first));
}

struct FilterOptions {
  int half_width_columns = 12;  ///< >= 1, of the rectangular window: 1 mm with the base sensor
  /// > 0; below the thinnest mat's 0.3 mm, so that the two sides of an edge do not support each
  /// other, and above the noise of a row.
  double half_height_m = 0.2e-3;
  int min_neighbors = 10;  ///< >= 0; Prepare scales it by the profile's share of measured points
};

/// The geometric filter (dissertation, section 3.2): keeps a point if at least `min_neighbors`
/// others lie within the rectangular window around it. O(columns x window).
/// @return the heights, NaN where a point was dropped or missing.
std::vector<float> FilterGeometric(std::span<const float> height_m, const FilterOptions& options);

/// Least-squares parabola c0 + c1 u + c2 u^2 through the finite points, where u is the column
/// mapped to [-1, 1]. Uses fewer terms if the points do not determine all of them (0 points: 0).
std::array<double, 3> FitQuadratic(std::span<const float> height_m);

/// Fills each hole with the heights of its two neighbors, half with each; an outer hole has one. A
/// profile without a finite point is not changed.
void FillHoles(std::span<float> height_m);

/// A preprocessed profile for the detectors.
struct PreparedProfile {
  std::vector<float> original_m;  ///< as measured, NaN where there was none
  std::vector<float> height_m;    ///< filtered, normalised, filled; empty if unusable
  int first_column = 0;           ///< first and last column with a point that passed the filter
  int last_column = 0;
  double time_s = 0.0;
  double moved_m = 0.0;  ///< Profile::moved_m

  bool Usable() const { return !height_m.empty(); }
};

/// Filter, normalisation, hole filling. Unusable if fewer than 128 points pass the filter.
PreparedProfile Prepare(const Profile& profile, const FilterOptions& options = {});

}  // namespace rangegrasp::seam
