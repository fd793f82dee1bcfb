#pragma once

#include "parts/shape/segmentation.h"
#include "parts/stretched/limbs.h"

namespace rangegrasp::parts {

/// Grows the core's hull of a segmented shape about its middle, as Katz et al. (2005) let their
/// core grow, into each protrusion as far as it falls apart into limbs (LabelLimbs).
/// @param shape  as it was given: its elements are joined as they are there
/// @param form   the same, in the places in which it was segmented
/// @param remoteness  of each point: its mean geodesic distance to all of the shape
Segmentation GrowCore(const Shape& shape, const Shape& form, const Segmentation& segmentation,
                      const std::vector<double>& remoteness, const LimbOptions& options);

}  // namespace rangegrasp::parts
