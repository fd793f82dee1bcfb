#pragma once

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// Joins parts that are the two sides of a thin wall, as inside and outside of a cup: half of the
/// smaller one's area has the other before or behind it, as parallel, within four edges. Noise
/// joins and pierces such walls, and what is left of them comes apart along the holes.
Segmentation JoinWalls(const Shape& mesh, const Segmentation& found);

}  // namespace rangegrasp::parts
