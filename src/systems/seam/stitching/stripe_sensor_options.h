#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/yaml_map.h"
#include "seam/profile.h"

namespace rangegrasp::stitching {

/// A laser-stripe sensor: laser plane straight down, a camera that looks at it at an angle, for
/// each column the row of the brightest pixel.
struct StripeSensorOptions {
  std::string name = "base";
  seam::LineGeometry line;
  std::vector<double> lines_ahead_m = {
      0.080};                    ///< fixed line first; more: those the second line switches between
  double standoff_m = 0.2;       ///< camera's distance from the point where it meets height 0
  double angle_rad = 0.6;        ///< between laser plane and optical axis
  int rows = 1024;               ///< height 0 is seen in the middle row; rows ascend with height
  double range_below_m = 0.045;  ///< heights that calibration covers, below ...
  double range_above_m = 0.03;   ///< ... and above height 0
  double rate_min_hz = 30.0;     ///< dark mats need long exposures ...
  double rate_max_hz = 100.0;    ///< ... bright ones short
  // What disturbs a row. Frozen settings: docs/seam.md.
  double row_sigma_px = 0.4;             ///< of a spot with full return
  double row_correlation_columns = 0.0;  ///< over which that noise fades: neighbors share speckles
  double row_quantum_px = 0.1;           ///< a row is found to within this; 0: no rounding
  double speckle = 0.5;  ///< its contrast: standard deviation of return strength, relative, 0..1
  double lost_return = 0.1;  ///< below this strength a spot is not found
  double outlier_share =
      0.01;  ///< found spots that are really a reflection, in runs of a few columns
  double outlier_run_columns = 4.0;
  double outlier_sigma_px = 40.0;
  double phantom_share =
      0.0;  ///< lost spots that report the brightest pixel of elsewhere instead of nothing
  double phantom_previous_share =
      0.5;  ///< phantoms that show the previous line; the others are in any row
};

/// @throws std::invalid_argument naming the key of the sensor file that is out of range.
void CheckOptions(const StripeSensorOptions& options);

/// Reads a file such as models/sensors/stripe_base.yaml.
/// @throws base::InputError naming file, line and key.
StripeSensorOptions ReadStripeSensor(const std::filesystem::path& file);
/// The same keys in a mapping, each within its own range; leaves Finish to the caller.
void ReadStripeSensor(base::YamlMap& map, StripeSensorOptions& options);

}  // namespace rangegrasp::stitching
