#pragma once

#include <filesystem>

#include "base/units.h"
#include "base/yaml_map.h"

namespace rangegrasp::sensing {

/// One camera on the scanner's pan/tilt unit that takes two pictures, turned by two angles (section
/// 5.3, figure 5.18). S is the scanner head's frame, whose y axis it turns about; the head's pitch
/// (-37 deg) is that of the scene's site. Turned by 0 the camera stands `ahead_m` before the axis
/// along S's z and looks along it: only ahead of the axis does a turn move it sideways, which is
/// the baseline b = ahead * 2 sin(turn / 2). The dissertation names neither its place nor its
/// lens; the defaults are those of docs/results.md.
///
/// These are the truth of what is simulated. Who looks at the pictures knows of them what a
/// calibration found.
struct StereoCameraOptions {
  int width = 1600;
  int height = 1200;
  double focal_px = 2000.0;
  // A lens is never built as it is drawn: its axis misses the sensor's middle, it bends what is
  // straight (5.10 to 5.12: barrel, less than 1 % in the corners, and a little decentred), and its
  // mount is a little off.
  double center_right_px = 7.3;  ///< of the principal point from the picture's middle
  double center_down_px = -5.8;
  double k1 = -0.11;
  double k2 = 0.14;
  double p1 = 0.0006;
  double p2 = -0.0004;
  double ahead_m = 0.30;
  double mount_right_m = 0.0021;  ///< further than `ahead_m` says
  double mount_down_m = -0.0014;
  double mount_roll_rad = base::Deg(0.6);
  double mount_pitch_rad = base::Deg(-0.4);
  double mount_yaw_rad = base::Deg(0.5);

  double left_pan_rad = base::Deg(-4.0);
  double right_pan_rad = base::Deg(0.0);
  /// Of the pan angle of each picture, about its nominal value. The unit's data sheet says 0.02 deg
  /// both ways; always come to from one side, it is better. b, and with it depth, hangs on it:
  /// see ExpectedStereoNoise.
  double pan_sigma_rad = base::Deg(0.002);

  int edge_samples = 0;  ///< of a pixel, for smooth edges; lens_blur_px smooths them too
  /// What is printed small on packages, which the models' labels leave out. Without it most of a
  /// package is of one colour, which is harder than what a kitchen holds.
  bool fine_print = true;
  int shadow_px = 2048;          ///< edge of the map of shadows, which spans the room
  double lens_blur_px = 0.6;     ///< standard deviation of the lens's blur
  double vignetting = 0.25;      ///< share of the light that is missing in the corners
  double exposure_sigma = 0.02;  ///< of each picture, as a share
  double noise_levels = 3.0;     ///< of each of red, green and blue, of 255: 2.0 in their grey
};

/// Reads models/sensors/stereo_camera.yaml; keys are the option names in human units; what is not
/// given keeps its default. @throws base::InputError as ReadLineScanner.
StereoCameraOptions ReadStereoCamera(const std::filesystem::path& file);

/// The same from a mapping, whose keys are documented by it.
StereoCameraOptions ReadStereoCamera(base::YamlMap& map);

/// @throws std::invalid_argument naming the key (in the units of a sensor file) that is out of
/// range, its value and its range.
void CheckOptions(const StereoCameraOptions& options);

}  // namespace rangegrasp::sensing
