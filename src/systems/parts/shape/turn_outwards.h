#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "parts/shape/clean_shape.h"

namespace rangegrasp::parts {

/// The faces turned so that neighbors agree, piece by piece, and each piece encloses a volume >= 0
/// as seen from its own middle: files often mix orientations. O(n log n)
std::vector<std::array<std::uint32_t, 3>> TurnedOutwards(const Shape& mesh);

}  // namespace rangegrasp::parts
