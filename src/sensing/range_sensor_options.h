#pragma once

#include <string>

#include "base/units.h"
#include "base/yaml_map.h"

namespace rangegrasp::sensing {

/// Options of all simulated range sensors: drop-outs, calibration error, and color camera.
/// ReadSharedKeys documents the fields.
struct RangeSensorOptions {
  double dropout_begin_rad = base::Deg(60.0);
  double dropout_end_rad = base::Deg(80.0);
  double saturation_angle_rad = base::Deg(5.0);
  double dropout_patch_m = 0.008;
  // Error of the head's pose that the robot knows: one draw per scan.
  double calibration_sigma_m = 0.001;
  double calibration_sigma_rad = base::Deg(0.1);
  // The color camera sees the room's light.
  bool color = false;
  double color_noise_levels = 2.0;
  double color_gain_sigma = 0.05;
  double color_shift_m = 0.001;  ///< root mean square; rows and columns together
};

/// Every shared key with its option, range and documentation.
/// @tparam Source  a file (base::YamlMap), or a check of ranges (base::RangeCheck)
template <typename Source, typename Options>
void ReadSharedKeys(Source& from, Options& o) {
  using base::kDeg;
  using base::kMm;
  from.ReadScaled("dropout_begin_deg", o.dropout_begin_rad, kDeg, 0.0, 90.0,
                  "angle of incidence above which samples are lost");
  from.ReadScaled("dropout_end_deg", o.dropout_end_rad, kDeg, 0.0, 90.0,
                  "angle of incidence above which all samples are lost");
  from.ReadScaled("saturation_angle_deg", o.saturation_angle_rad, kDeg, 0.0, 180.0,
                  "angle to the mirror direction below which gloss blinds the camera");
  from.ReadScaled("dropout_patch_mm", o.dropout_patch_m, kMm, 0.0, 1000.0,
                  "size of the patches of samples that are lost together because of incidence or "
                  "gloss; 0: single samples");
  from.ReadScaled("calibration_sigma_mm", o.calibration_sigma_m, kMm, 0.0, 1000.0,
                  "calibration error of the head's position, root mean square");
  from.ReadScaled("calibration_sigma_deg", o.calibration_sigma_rad, kDeg, 0.0, 90.0,
                  "calibration error of the head's orientation, root mean square");
  from.Read("color", o.color, "the sensor also measures each sample's color, in the room's light");
  from.Read("color_noise_levels", o.color_noise_levels, 0.0, 255.0, "noise of the color, of 255");
  from.Read("color_gain_sigma", o.color_gain_sigma, 0.0, 1.0,
            "error of the color channels' balance, relative; one draw per channel and scan");
  from.ReadScaled("color_shift_mm", o.color_shift_m, kMm, 0.0, 100.0,
                  "distance between a sample and its color, root mean square; one draw per scan");
}

/// Finishes reading a sensor's file. @throws base::InputError for an unknown key, or unless
/// dropout_begin is less than dropout_end.
void FinishShared(const base::YamlMap& map, const RangeSensorOptions& options);
/// @throws std::invalid_argument unless dropout_begin is less than dropout_end.
void CheckShared(const std::string& what, const RangeSensorOptions& options);

}  // namespace rangegrasp::sensing
