#include "seam/profile_format.h"

#include "base/units.h"
#include "base/words.h"

namespace rangegrasp::seam {
namespace {

using base::kMm;
using base::YamlMap;

// Reads a list of numbers, which may be strings in YAML.
void ReadNoValues(YamlMap& map, ProfileFileOptions& options) {
  std::vector<std::string> words;
  map.Read("no_values", words,
           "numbers that stand for missing values, in addition to nan; default: 0 in images of 16 "
           "bits, -32768 in signed ones");
  if (!map.Has("no_values")) return;
  std::vector<double> numbers;
  for (const std::string& word : words) {
    const auto number = base::NumberFrom<double>(word);
    if (!number) map.Fail("no_values", "'" + word + "' must be a number");
    numbers.push_back(*number);
  }
  for (HeightScale* scale :
       {&options.text.scale, &options.grey, &options.signed_grey, &options.real}) {
    scale->no_values = numbers;
  }
}

void ReadImageScale(YamlMap& map, ProfileFileOptions& options) {
  double scale_m = options.grey.unit_m;
  double offset_m = -options.grey.zero * options.grey.unit_m;
  map.ReadScaled("image_scale_mm", scale_m, kMm, 1e-9, 1e3,
                 "images: height of one grey level; default for floating-point images: 1");
  map.ReadScaled("image_offset_mm", offset_m, kMm, -1e6, 1e6,
                 "images: height of level 0; by default level 32768 has height 0; default for "
                 "signed and floating-point images: 0");
  const bool has_scale = map.Has("image_scale_mm");
  for (HeightScale* scale : {&options.grey, &options.signed_grey, &options.real}) {
    if (has_scale) scale->unit_m = scale_m;
    if (map.Has("image_offset_mm")) scale->zero = -offset_m / scale->unit_m;
  }
}

void ReadTextColumns(YamlMap& map, TextFormat& text) {
  map.Read("time_column", text.time_column, "number, from 1, or name of the time column");
  map.Read("encoder_column", text.encoder_column, "number or name of the encoder column");
  map.Read("axis_column", text.axis_column,
           "number or name of the column with the type of a row: Z heights, X the x of the next "
           "row; other rows are skipped");
  map.Read("profile_column", text.profile_column,
           "layout points: column of the profile's number; default: an empty line ends a profile");
  map.Read("z_column", text.z_column,
           "layout points: column of the height; default: the one after x");
  map.Read(
      "first_column", text.first_column,
      "first column of the heights (layouts pairs, points and columns: of x); default: the one "
      "after all columns named above");
  map.Read("x_in_header", text.x_in_header, "whether the header has the x of each height");
}

void ReadText(YamlMap& map, TextFormat& text) {
  map.Read(
      "layout", text.layout,
      "rows: a line is a profile. pairs: a line is a profile x, height, x, height, and all have "
      "the same number of points (else use points). points: a line is a point x, height. columns: "
      "the first column is x, each other column is a profile");
  map.Read("separator", text.separator,
           "separator of columns; auto: semicolons if there are any, else commas, else blanks");
  map.Read("decimal_comma", text.decimal_comma, "whether numbers have a decimal comma: 1,5");
  map.Read("header_lines", text.header_lines, 0, 10'000,
           "number of header lines; the last one has the column names");
  map.Read("header", text.header,
           "instead of header_lines: first field of the line with the column names; lines before "
           "it are skipped");
  map.Read("sections", text.sections,
           "read only the lines between a line with one of these words and a line End");
  ReadTextColumns(map, text);
  map.ReadScaled("unit_mm", text.scale.unit_m, kMm, 1e-9, 1e6,
                 "unit of heights and x in a text file");
}

// LMI Technologies, "Gocator Line Profile Sensors: User Manual" (2100 series), CSV File Format,
// pages 708 to 714: sections end with a line End. A section of profiles has attributes, then a
// header "Frame, Source, Time, Encoder, Z Encoder, Inputs, Exposure, Y, Axis, (x values)" and a row
// for each axis: Z ranges in mm, X (RawProfile) in mm, I intensities. The header's x are those of
// Profile. Time stamps are in microseconds in the sensor's own protocol; the page does not say.
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
// on docs.rs): level = height / (8 unit) + 32768, where unit is the head's in 0.01 um; 0 is a
// missing value. One level is thus 0.08 um times that unit, which image_scale_mm must state.
constexpr std::string_view kKeyence = R"(
no_values: [0]
)";

// Keyence, "LJ-V7000 Communications Library Reference Manual", 11.2 Save file format: text with
// tabs; the first column has X coordinates, the others profiles, with values as received from the
// sensor: 0.01 um. Missing values are those of the library's headers: 0x80000000 to 0x80000003 as
// signed numbers.
constexpr std::string_view kKeyenceText = R"(
layout: columns
separator: tab
unit_mm: 1e-5
no_values: [-2147483648, -2147483647, -2147483646, -2147483645]
)";

// SICK, "Ranger3 Operating Instructions" (8020774), 7.8: "The pixel value 0 is dedicated to
// represent missing data"; "Ruler3000 Operating Instructions" (8026049), 16.2.4:
// Scan3dCoordinateScale and Scan3dCoordinateOffset convert a pixel to mm, so image_scale_mm and
// image_offset_mm must have the camera's values.
constexpr std::string_view kSick = R"(
image_offset_mm: 0
no_values: [0]
)";

}  // namespace

void ReadProfileFileOptions(YamlMap map, ProfileFileOptions& options) {
  TextFormat& text = options.text;
  ReadText(map, text);
  ReadImageScale(map, options);
  ReadNoValues(map, options);
  map.Read("away", options.away, "whether heights increase away from the sensor");
  map.ReadScaled("min_height_mm", options.min_height_m, kMm, -1e6, 1e6,
                 "minimum valid height in the file");
  map.ReadScaled("max_height_mm", options.max_height_m, kMm, -1e6, 1e6,
                 "maximum valid height in the file");
  map.Read("time_unit_s", options.time_unit_s, 1e-12, 3600.0, "unit of the time column");
  map.ReadScaled("encoder_mm", options.encoder_m, kMm, -1e3, 1e3,
                 "path per encoder count; below 0: it counts down");
  map.ReadScaled(
      "feed_mm_per_s", options.feed_m_per_s, kMm, 1e-3, 1e5,
      "feed speed, from which times are computed if there is an encoder but no time column");
  map.Read("max_gap_s", options.max_gap_s, 0.0, 3600.0,
           "maximum time between two rows; more is an outage; 0: ten times the time between the "
           "first two. Without a time or encoder column there are no gaps");
  if (text.header_lines > 0 && !text.header.empty()) {
    map.Fail("header", "cannot be used with header_lines; give one of them");
  }
  if (text.decimal_comma && text.separator == TextSeparator::kComma) {
    map.Fail("decimal_comma",
             "with commas between columns, decimal commas are ambiguous; separator must be "
             "semicolon, tab or blank");
  }
  if (text.x_in_header && text.header_lines == 0 && text.header.empty()) {
    map.Fail("x_in_header", "needs a header: header_lines or header");
  }
  if (options.encoder_m == 0.0) map.Fail("encoder_mm", "must not be 0");
  if (options.min_height_m >= options.max_height_m) {
    map.Fail("min_height_mm", "must be below max_height_mm");
  }
  map.Finish();
}

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
