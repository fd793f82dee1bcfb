#pragma once

#include <optional>
#include <span>

#include "perception/internal/part.h"
#include "perception/internal/planar.h"

namespace rangegrasp::perception::internal {

/// A part with its unseen sides closed (section 5.1.4).
struct Completion {
  geometry::Points points_C;         ///< the part's and those added; none lower than the base
  geometry::TriangleMesh surface_C;  ///< see the functions
};

/// Completes a part that is not rotational: symmetric completion where it applies, strays off the
/// outline left out, then planes square to the table from the outline down to the base. The surface
/// is the convex hull, or, where the outline is not nearly convex, hulls of slices along the
/// longest axis.
Completion CompleteOther(const ObjectContext& context, const Part& part, double base_m);

/// The rectangle round a footprint, along the top surface's principal axis where that has a
/// direction, else the one of least area; length_m >= width_m.
Rectangle FootprintBox(const PlanarFrame& frame, std::span<const Eigen::Vector2d> flat,
                       const std::optional<TopSurface>& top, const CompletionOptions& options);

}  // namespace rangegrasp::perception::internal
