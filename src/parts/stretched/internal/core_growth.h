#pragma once

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// Grows the core's hull of a segmented mesh about its middle, as Katz et al. (2005) let their core
/// grow, to the size where most parts that count come off; the smallest such.
/// @param max_growth  >= 1; the factor up to which it grows.
Segmentation GrowCore(const Shape& mesh, const Segmentation& segmentation, double max_growth);

}  // namespace rangegrasp::parts
