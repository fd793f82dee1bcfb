#pragma once

#include <cstdint>

#include "seam/stitching/mats.h"

namespace rangegrasp::stitching {

/// A random seam as a production would show them: shape, height 0.3 to 1.1 mm, course (straight or
/// curved), mat type (texture scaled round `typical`), tilt. Depends on the seed alone.
MatOptions RandomMats(EdgeShape shape, const MatTexture& typical, bool curved, std::uint64_t seed);

/// Puts a hazard in the way of a head that follows the edge: with even chances the mats end, or an
/// obstacle lies within 10 mm of the needle's path. It lies 150 to 250 mm along the track, so that
/// the loop has settled before. Depends on the mats' course and the seed alone.
/// @param wanted_distance_m  of the needle from the edge, on its low side.
void AddRandomHazard(MatOptions& mats, double wanted_distance_m, std::uint64_t seed);

}  // namespace rangegrasp::stitching
