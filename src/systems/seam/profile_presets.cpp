#include "seam/profile_presets.h"

#include "base/error.h"
#include "base/words.h"

namespace rangegrasp::seam {
namespace {

// LMI Technologies, "Gocator Line Profile Sensors: User Manual" (2100 series), CSV File Format,
// pages 708 to 714: sections that a line End ends; of a section of profiles the attributes, then a
// header "Frame, Source, Time, Encoder, Z Encoder, Inputs, Exposure, Y, Axis, (x values)" and a row
// for each axis: Z ranges in mm, X (RawProfile) in mm, I intensities. The header's x are those of
// Profile. A stamp's time is in microseconds in the sensor's own protocol; the page does not say.
constexpr std::string_view kGocator = R"(
separator: comma
sections: [Profile, RawProfile]
header: Frame
time_column: Time
axis_column: Axis
x_in_header: true
time_unit_s: 1e-6
)";

// Keyence, LJ-X8000A communication library, ProfileDataConvert.cpp (as in the crate ljxacom 0.1.2
// on docs.rs): level = height / (8 unit) + 32768, where unit is the head's in 0.01 um; 0 is no
// value. So a level is 0.08 um times that unit, which image_scale_mm must tell.
constexpr std::string_view kKeyence = R"(
no_values: [0]
)";

// Keyence, "LJ-V7000 Communications Library Reference Manual", 11.2 Save file format: text with
// tabs, the first column X coordinates, then profiles, values as they were got from the sensor:
// 0.01 um. No values are those of the library's headers: 0x80000000 to 0x80000003 as signed
// numbers.
constexpr std::string_view kKeyenceText = R"(
layout: columns
separator: tab
unit_mm: 1e-5
no_values: [-2147483648, -2147483647, -2147483646, -2147483645]
)";

// SICK, "Ranger3 Operating Instructions" (8020774), 7.8: "The pixel value 0 is dedicated to
// represent missing data"; "Ruler3000 Operating Instructions" (8026049), 16.2.4:
// Scan3dCoordinateScale and Scan3dCoordinateOffset turn a pixel into mm, so that image_scale_mm and
// image_offset_mm must be stated as the camera tells them.
constexpr std::string_view kSick = R"(
image_offset_mm: 0
no_values: [0]
)";

}  // namespace

const std::vector<FormatPreset>& FormatPresets() {
  static const std::vector<FormatPreset> presets = {
      {"gocator", "LMI Gocator: exported CSV, Profile or RawProfile", kGocator, ""},
      {"keyence", "Keyence LJ-X: 16-bit height image", kKeyence, "image_scale_mm"},
      {"keyence_text", "Keyence LJ-V, LJ-X: text of the communication library", kKeyenceText, ""},
      {"sick", "SICK Ranger3, Ruler3000: 16-bit range image", kSick, "image_scale_mm"},
  };
  return presets;
}

const FormatPreset& PresetOf(std::string_view name) {
  std::vector<std::string> names;
  for (const FormatPreset& preset : FormatPresets()) names.emplace_back(preset.name);
  return FormatPresets()[base::WordPosition(name, names, "--preset")];
}

}  // namespace rangegrasp::seam
