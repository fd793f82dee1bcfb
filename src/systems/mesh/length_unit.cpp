#include "mesh/length_unit.h"

#include <cmath>

namespace rangegrasp::objects {

double MetersOf(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::kMm:
      return 0.001;
    case LengthUnit::kCm:
      return 0.01;
    case LengthUnit::kInch:
      return 0.0254;
    case LengthUnit::kM:
      break;
  }
  return 1.0;
}

std::optional<LengthUnit> GuessUnit(double longest, const SizeRange& sizes) {
  std::optional<LengthUnit> best;
  const auto distance = [&](LengthUnit unit) {
    return std::abs(std::log(longest * MetersOf(unit) / sizes.typical_m));
  };
  for (const LengthUnit unit : {LengthUnit::kMm, LengthUnit::kCm, LengthUnit::kM}) {
    const double size_m = longest * MetersOf(unit);
    if (size_m < sizes.likely_min_m || size_m > sizes.likely_max_m) continue;
    if (!best || distance(unit) < distance(*best)) best = unit;
  }
  return best;
}

}  // namespace rangegrasp::objects
