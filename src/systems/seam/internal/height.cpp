#include "seam/internal/height.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace rangegrasp::seam {

float HeightOf::operator()(double number, std::string& fault) const {
  constexpr float kMissingHeight = std::numeric_limits<float>::quiet_NaN();
  const auto& none = scale_.no_values;
  if (std::isnan(number) || std::ranges::find(none, number) != none.end()) return kMissingHeight;
  const double height = (number - scale_.zero) * scale_.unit_m;
  if (!(height >= options_.min_height_m && height <= options_.max_height_m)) {
    fault = fmt::format("is out of range; it must be from {:.6g} to {:.6g}",
                        options_.min_height_m / scale_.unit_m + scale_.zero,
                        options_.max_height_m / scale_.unit_m + scale_.zero);
    return kMissingHeight;
  }
  return static_cast<float>(options_.away ? -height : height);
}

}  // namespace rangegrasp::seam
