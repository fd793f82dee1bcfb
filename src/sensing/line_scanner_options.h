#pragma once

#include <filesystem>

#include "base/units.h"
#include "base/yaml_map.h"

namespace rangegrasp::sensing {

/// A laser plane and a camera on one head that pans. The head's frame S (x right, y down, z
/// forward) has its origin in the laser's exit point; the pan axis is S's y axis. In the frame P of
/// one profile (S turned by the pan angle) the laser's fan is the half plane x = 0, z > 0 with its
/// apex in the origin, and the camera stands at (baseline, 0, 0), turned about y so that its axis
/// meets the fan at z = focus_distance. "Depth" is z_P.
///
/// Defaults: a 512 x 512 sensor with 9.5 um pixels and a lens that sees the whole fan with the 512
/// columns; of its rows a window is read that ends before the floor behind the table.
struct LineScannerOptions {
  int samples = 512;  ///< a profile: rays evenly spaced in the tangent of the fan's angle
  int profiles = 150;
  double fan_rad = base::Deg(42.0);        ///< opening of the fan, and of the camera along the line
  double pan_range_rad = base::Deg(34.0);  ///< from first to last profile, symmetric round S's z
  double baseline_m = 0.30;
  double focal_length_m = 0.0063;
  double pixel_pitch_m = 9.5e-6;
  int sensor_pixels = 256;        ///< read across the line: limits the depths that are seen
  double focus_distance_m = 0.9;  ///< depth at which the camera's axis meets the fan
  double near_m = 0.20;  ///< surfaces nearer to the head than this are its own and hide nothing
  double line_width_m = 0.001;       ///< 1/e^2 width of the (collimated) line on a surface
  double blur_px = 2.5;              ///< 1/e^2 width that lens and pixels add to the line's image
  double centroid_sigma_px = 0.07;   ///< white noise of the line's centroid
  double speckle_sigma_m = 0.0002;   ///< depth noise by speckle at a depth of 1 m
  double correlation_samples = 2.0;  ///< 1/e length of the speckle along the line
  double quantisation_px = 0.0625;   ///< step of the centroid; 0: none
  double pan_jitter_rad = base::Deg(0.02);       ///< sigma of the pan angle, one value a profile
  double dropout_begin_rad = base::Deg(60.0);    ///< incidence from which samples drop out
  double dropout_end_rad = base::Deg(80.0);      ///< incidence from which all are lost
  double saturation_angle_rad = base::Deg(5.0);  ///< gloss blinds this near the mirror direction
  /// Edge of the patches that are lost or kept as a whole to incidence and gloss; 0: each sample by
  /// itself.
  double dropout_patch_m = 0.008;
  // By how far the head's pose, as the robot knows it, is off: one draw a scan.
  double calibration_sigma_m = 0.001;             ///< root mean square of the distance
  double calibration_sigma_rad = base::Deg(0.1);  ///< and of the angle
  // The camera's second exposure, in color and by the room's light, with the laser off.
  bool color = false;
  double color_noise_levels = 2.0;  ///< sigma, of 255
  /// Of the balance and exposure of its channels, as a share; one draw a channel and scan.
  double color_gain_sigma = 0.05;
  /// By how far a sample's color is seen beside it, along and across the line at the focus
  /// distance: root mean square, one draw a scan.
  double color_shift_m = 0.001;
};

/// Reads models/sensors/*.yaml; keys are the option names in human units; what is not given keeps
/// its default.
/// @throws base::InputError naming file, line and key (and the nearest valid key for an unknown
/// one) if the file cannot be read, a key is unknown or twice, or a value is of the wrong type or
/// out of range.
LineScannerOptions ReadLineScanner(const std::filesystem::path& file);

/// The same from a mapping, which documents its keys.
LineScannerOptions ReadLineScanner(base::YamlMap& map);

/// @throws std::invalid_argument naming the key (in the units of a sensor file) that is out of
/// range, its value and its range.
void CheckOptions(const LineScannerOptions& options);

}  // namespace rangegrasp::sensing
