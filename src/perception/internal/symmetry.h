#pragma once

#include "perception/internal/part.h"

namespace rangegrasp::perception::internal {

/// The mirror image (ridges and inclined tops: about the vertical plane through the ridge or the
/// upper edge) or the half-turn image (tops much smaller than the body: about the vertical through
/// the top's center) of the part's points, without those in space that the sensor saw through or
/// under the table. Empty where neither applies, or where more of the image than the options allow
/// is in space known to be free.
geometry::Points SymmetricImage(const ObjectContext& context, const Part& part);

}  // namespace rangegrasp::perception::internal
