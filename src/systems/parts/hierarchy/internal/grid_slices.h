#pragma once

#include <cstdint>
#include <vector>

#include "parts/shape/clean_shape.h"

namespace rangegrasp::parts {

/// Cuts some faces of a mesh along the planes of a grid (x, y or z a multiple of `side`), so that
/// none of them reaches over a plane; faces beside them are cut where they share a cut edge.
/// Nothing is cut where that would be more than 20,000 cuts and two a face.
/// @param origin  of each face, handed on to its parts.
/// @param chosen  of each origin, whether it is to be cut.
void SliceAlongGrid(double side, const std::vector<bool>& chosen, Shape& mesh,
                    std::vector<std::uint32_t>& origin);

}  // namespace rangegrasp::parts
