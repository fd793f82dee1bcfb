#pragma once

#include <string_view>
#include <vector>

namespace rangegrasp::seam {

/// The format of a sensor family's files, as its publisher describes it.
struct FormatPreset {
  std::string_view name;
  std::string_view about;
  std::string_view yaml;   ///< keys that ReadProfileFileOptions reads
  std::string_view needs;  ///< a key that differs from sensor to sensor: it must be stated, too
};
const std::vector<FormatPreset>& FormatPresets();

/// @throws base::InputError if there is no preset of that name.
const FormatPreset& PresetOf(std::string_view name);

}  // namespace rangegrasp::seam
