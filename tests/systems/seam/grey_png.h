#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "base/image/image.h"

namespace rangegrasp::seam {

/// Rows of equal length as a 16-bit PNG with levels scale * value + zero; NaN becomes 0.
inline std::string GreyPng(const std::vector<std::vector<double>>& rows, double scale,
                           double zero) {
  image::Grey16 image{static_cast<int>(rows.front().size()), static_cast<int>(rows.size()), {}};
  for (const std::vector<double>& row : rows) {
    for (const double value : row) {
      const double level = std::isnan(value) ? 0.0 : std::round(scale * value + zero);
      image.grey.push_back(static_cast<std::uint16_t>(level));
    }
  }
  return image::EncodePng(image);
}

}  // namespace rangegrasp::seam
