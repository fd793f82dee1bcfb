#pragma once

#include <filesystem>

#include "base/units.h"
#include "sensing/range_sensor_options.h"

namespace rangegrasp::sensing {

/// A laser plane and a camera on a panning head. The origin of the head's frame S (x right, y down,
/// z forward) is the laser's exit point; the pan axis is S's y axis. In the frame P of one profile
/// (S rotated by the pan angle) the laser's fan is the half plane x = 0, z > 0 with its apex in the
/// origin. The camera is at (baseline, 0, 0), rotated about y so that its axis meets the fan at
/// z = focus_distance. "Depth" is z_P.
///
/// Defaults: a 512 x 512 sensor with 9.5 um pixels. Its lens images the whole fan onto the 512
/// columns. Only a window of the rows is read, which ends before the floor behind the table.
struct LineScannerOptions : RangeSensorOptions {
  // The keys of line_scanner_options.cpp document the fields.
  int samples = 512;  ///< evenly spaced in the tangent of the fan's angle
  int profiles = 150;
  double fan_rad = base::Deg(42.0);
  double pan_range_rad = base::Deg(34.0);
  double baseline_m = 0.30;
  double focal_length_m = 0.0063;
  double pixel_pitch_m = 9.5e-6;
  int sensor_pixels = 256;
  double focus_distance_m = 0.9;
  double near_m = 0.20;
  double line_width_m = 0.001;  ///< of the collimated line
  double blur_px = 2.5;
  double centroid_sigma_px = 0.07;
  double speckle_sigma_m = 0.0002;
  double correlation_samples = 2.0;
  double quantisation_px = 0.0625;
  double pan_jitter_rad = base::Deg(0.02);
};

/// Reads models/sensors/*.yaml; missing keys keep their defaults.
/// @throws base::InputError naming file, line and key.
LineScannerOptions ReadLineScanner(const std::filesystem::path& file);
inline constexpr const char* kLineScanner = "line_scanner";

/// @throws std::invalid_argument naming the key (in the units of a sensor file) that is out of
/// range, its value and its range.
void CheckOptions(const LineScannerOptions& options);

}  // namespace rangegrasp::sensing
