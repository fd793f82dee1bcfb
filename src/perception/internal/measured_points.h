#pragma once

#include <optional>
#include <vector>

#include "geometry/observation.h"
#include "perception/perceive.h"
#include "perception/scene.h"

namespace rangegrasp::perception::internal {

/// The points that perception works on, and where each was seen from.
struct MeasuredPoints {
  geometry::Points points_C;      ///< view after view, each in the order of its scan
  std::vector<SampleId> samples;  ///< one a point
  /// The places that sensors stood at, in the order of their first point. Places closer together
  /// than half a cell of directions at 1 m are one: they saw the same.
  geometry::Points places_C;
  geometry::Indices place_of;  ///< one a point: position in places_C
};

/// The finite samples of all views, without those outside the workspace.
/// @throws std::invalid_argument if a view has neither one origin nor one a profile.
MeasuredPoints Gather(const geometry::Observation& observation,
                      const std::optional<Workspace>& workspace);

}  // namespace rangegrasp::perception::internal
