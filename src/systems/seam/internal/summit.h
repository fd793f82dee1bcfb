#pragma once

#include <algorithm>

namespace rangegrasp::seam::internal {

/// Where between its neighbors a greatest value has its summit, by the parabola through the three:
/// from -0.5 to 0.5 of their distance.
inline double SummitOffset(double before, double greatest, double after) {
  const double bend = before - 2.0 * greatest + after;
  return bend < 0.0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

}  // namespace rangegrasp::seam::internal
