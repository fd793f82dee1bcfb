#include "seam/internal/profile_bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <string_view>

#include "base/error.h"
#include "base/image/png.h"
#include "seam/image/pgm.h"
#include "seam/image/tiff.h"
#include "seam/internal/image_rows.h"
#include "seam/internal/raw_row.h"

namespace rangegrasp::seam {
namespace {

using base::InputError;

void AppendNumber(std::string& text, double number) {
  char digits[400];  // of the largest double
  auto* end =
      std::to_chars(std::begin(digits), std::end(digits), number, std::chars_format::fixed, 6).ptr;
  while (end[-1] == '0') --end;
  if (end[-1] == '.') --end;
  const std::string_view shown(digits, static_cast<std::size_t>(end - digits));
  text += shown == "-0" ? "0" : shown;
}

std::string CsvOf(const std::vector<Profile>& profiles, const ProfileFileOptions& options) {
  std::string text;
  for (const Profile& profile : profiles) {
    for (std::size_t i = 0; i < profile.height_m.size(); ++i) {
      if (i > 0) text += ',';
      const auto height = static_cast<double>(profile.height_m[i]);
      if (std::isfinite(height)) {
        AppendNumber(text, height / options.text.scale.unit_m);
      } else {
        text += "nan";
      }
    }
    text += '\n';
  }
  return text;
}

// The grey level of a height; 0 is no value, so what would fall on it takes the next one.
std::uint16_t GreyOf(float height_m, const ProfileFileOptions& options) {
  if (!std::isfinite(height_m)) return 0;
  const double grey =
      std::round(static_cast<double>(height_m) / options.grey.unit_m + options.grey.zero);
  if (!(grey >= 0.0 && grey <= 65535.0)) {
    throw InputError(fmt::format("height {:.6g} m does not fit into 16 bits of {:.6g} m", height_m,
                                 options.grey.unit_m));
  }
  return static_cast<std::uint16_t>(std::max(grey, 1.0));
}

image::Grey16 ImageOf(const std::vector<Profile>& profiles, const ProfileFileOptions& options) {
  const std::size_t columns = profiles[0].height_m.size();
  image::Grey16 image{static_cast<int>(columns), static_cast<int>(profiles.size()), {}};
  image.grey.reserve(profiles.size() * columns);
  for (std::size_t row = 0; row < profiles.size(); ++row) {
    for (std::size_t i = 0; i < columns; ++i) {
      try {
        image.grey.push_back(GreyOf(profiles[row].height_m[i], options));
      } catch (const InputError& error) {
        throw InputError(fmt::format("row {}, column {}: {}", row + 1, i + 1, error.what()));
      }
    }
  }
  return image;
}

void CheckShape(const std::vector<Profile>& profiles) {
  if (profiles.empty()) throw InputError("there is no profile to write");
  const std::size_t columns = profiles[0].height_m.size();
  if (columns == 0) throw InputError("row 1 has no columns");
  for (std::size_t row = 0; row < profiles.size(); ++row) {
    if (profiles[row].height_m.size() == columns) continue;
    throw InputError(
        fmt::format("row {} {}", row + 1,
                    WidthFault(profiles[row].height_m.size(), static_cast<int>(columns))));
  }
}

}  // namespace

std::string UnknownEnding(const std::string& ending) {
  return "unknown ending '" + ending + "'; profiles are .csv, .txt, .png, .pgm, .tif or .tiff";
}

std::string BytesOf(const std::vector<Profile>& profiles, const std::string& ending,
                    const ProfileFileOptions& options) {
  CheckShape(profiles);
  if (ending == ".csv" || ending == ".txt") return CsvOf(profiles, options);
  if (ending == ".png") return image::EncodePng(ImageOf(profiles, options));
  if (ending == ".pgm") return image::EncodePgm(ImageOf(profiles, options));
  if (IsImageEnding(ending)) return image::EncodeTiff(ImageOf(profiles, options));
  throw InputError(UnknownEnding(ending));
}

}  // namespace rangegrasp::seam
