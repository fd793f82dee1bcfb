#pragma once

#include "seam/stitching/closed_loop.h"

namespace rangegrasp::stitching::internal {

/// Compares a track with the truth: fills distance_m of its path, reached_hazard and the errors.
void Score(const Mats& mats, double wanted_distance_m, TrackResult& result);

}  // namespace rangegrasp::stitching::internal
