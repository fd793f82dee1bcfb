#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "base/yaml_map.h"

namespace rangegrasp::seam {

/// Layout of profiles in a text.
enum class TextLayout {
  kRows,     ///< a line is a profile: heights
  kPairs,    ///< a line is a profile: x, height, x, height, ...
  kPoints,   ///< a line is a point: x, height; an empty line or new number starts a profile
  kColumns,  ///< the first column is x, each other one is a profile
};
constexpr std::array<std::string_view, 4> WordsOf(TextLayout) {
  return {"rows", "pairs", "points", "columns"};
}

/// Adjacent tabs enclose an empty value; a blank separator is a run of blanks and tabs.
enum class TextSeparator { kAuto, kComma, kSemicolon, kTab, kBlank };
constexpr std::array<std::string_view, 5> WordsOf(TextSeparator) {
  return {"auto", "comma", "semicolon", "tab", "blank"};
}

/// A number in a file means the height (number - zero) * unit_m.
struct HeightScale {
  double unit_m = 1e-3;  ///< > 0
  double zero = 0.0;
  std::vector<double> no_values;  ///< numbers that mean "nothing measured", besides nan
};

/// How lines of a text become profiles: the keys of `file`. A column is given by its number, from
/// 1, or its name in the header; empty: there is no such column.
struct TextFormat {
  TextLayout layout = TextLayout::kRows;
  TextSeparator separator = TextSeparator::kAuto;
  bool decimal_comma = false;
  int header_lines = 0;
  std::string header;
  std::vector<std::string> sections;
  std::string time_column, encoder_column, axis_column, profile_column;
  std::string z_column, first_column;
  bool x_in_header = false;
  HeightScale scale;  ///< x has the same unit
};

/// Format of a file of profiles and the meaning of its numbers.
struct ProfileFileOptions {
  TextFormat text;
  // Images: a row is a profile.
  HeightScale grey{1e-6, 32768.0, {0.0}};          ///< 16 bits
  HeightScale signed_grey{1e-6, 0.0, {-32768.0}};  ///< 16 bits, signed
  HeightScale real{1e-3, 0.0, {}};                 ///< floating point
  int columns = 0;              ///< expected columns; 0: majority of the first three valid rows
  bool away = false;            ///< heights increase away from the sensor: their sign is inverted
  double rate_hz = 62.0;        ///< > 0: profiles per second; gives the times if the file does not
  double time_unit_s = 1.0;     ///< > 0
  double encoder_m = 1e-3;      ///< not 0: path per encoder count
  double feed_m_per_s = 30e-3;  ///< > 0
  double max_gap_s = 0.0;
  double min_height_m = -0.2;  ///< limit of heights before their sign is inverted
  double max_height_m = 0.2;
  double columns_per_m = 0.0;  ///< of the even grid for x; 0: by the spacing of the points
};

/// Reads the keys of ProfileFileOptions except rate and columns; absent keys keep their defaults.
/// @throws base::InputError naming file, line and key.
void ReadProfileFileOptions(base::YamlMap map, ProfileFileOptions& options);

/// File format of a sensor family, as its publisher describes it.
struct FormatPreset {
  std::string_view name;
  std::string_view about;
  std::string_view yaml;   ///< keys for ReadProfileFileOptions
  std::string_view needs;  ///< a key that depends on the sensor and must be given as well
};
const std::vector<FormatPreset>& FormatPresets();

/// @throws base::InputError if there is no preset of that name.
const FormatPreset& PresetOf(std::string_view name);

}  // namespace rangegrasp::seam
