#pragma once

#include "perception/internal/objects.h"
#include "perception/internal/planar.h"

namespace rangegrasp::perception::internal {

/// The mirror image of the part's points (ridges and inclined tops: about the vertical plane
/// through the ridge or the upper edge) or their half-turn image (tops much smaller than the body:
/// about the vertical through the top's center), without points under the table or in space that
/// the sensor saw through. Empty if neither applies, or if more of the image than the options allow
/// is in space known to be free.
Points SymmetricImage(const ObjectContext& context, const Part& part);

/// A part with its unseen sides closed (section 5.1.4).
struct Completion {
  Points points_C;         ///< the part's and those added; none lower than the base
  TriangleMesh surface_C;  ///< see the functions
};

/// Completes a part that is not rotational: by symmetry if that applies, without strays, then by
/// planes normal to the table from the outline down to the base. The surface is the convex hull or,
/// if the outline is not nearly convex, hulls of slices along the longest axis.
Completion CompleteOther(const ObjectContext& context, const Part& part, double base_m);

/// The rectangle around a footprint: along the top surface's principal axis if the top has a
/// direction, else the one of least area; length_m >= width_m.
Rectangle FootprintBox(const PlanarFrame& frame, std::span<const Vector2d> flat,
                       const std::optional<TopSurface>& top, const CompletionOptions& options);

/// Completes a rotational part (section 5.1.4): the points that face across the axis and agree with
/// their section are rotated about the axis in the options' steps. One point per section is
/// rotated, at the section's radius; rotating every one would give the same circles 30 times over.
/// Sections that were not seen are interpolated between their neighbors; the lowest continues down
/// to the base. The surface is one of revolution, with the cavity of an open container; points off
/// the circles (a handle) are added as convex pieces.
Completion CompleteRotational(const ObjectContext& context, const Part& part, double base_m);

}  // namespace rangegrasp::perception::internal
