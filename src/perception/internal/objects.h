#pragma once

#include <vector>

#include "base/rng.h"
#include "perception/internal/part.h"

namespace rangegrasp::perception::internal {

/// Sections 5.1.3 and 5.1.4 over all segments: top surfaces, circles, merging of clipped rotational
/// parts and of fragments, completion, order: topmost first, to the millimetre; then the larger.
/// Appends the seconds of its steps.
std::vector<PerceivedObject> BuildObjects(const geometry::PointCloud& cloud,
                                          const std::vector<geometry::Indices>& segments,
                                          const geometry::Plane& table, const SensorViews& views,
                                          const FeatureOptions& options, base::Rng& rng,
                                          StageSeconds& seconds);

}  // namespace rangegrasp::perception::internal
