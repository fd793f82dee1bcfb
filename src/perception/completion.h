#pragma once

#include <optional>

#include "perception/merge.h"
#include "perception/rotational.h"
#include "perception/sensor_view.h"

namespace rangegrasp::perception {

/// What completion reads.
struct CompletionContext {
  const geometry::PointCloud& cloud;
  const geometry::Plane& table;
  const SensorView& view;
  const FeatureOptions& options;
};

/// A part with its unseen sides closed (section 5.1.4).
struct Completion {
  geometry::Points points_C;         ///< the part's and those added; none lower than the base
  geometry::TriangleMesh surface_C;  ///< see the functions
};

/// Rotational parts: the points square to the axis that agree with their section are turned about
/// the axis in the options' steps. One point a section is turned, at the section's radius; turning
/// every one would give the same circles 30 times over. Sections that were not seen lie between
/// their neighbours; the lowest goes on down to the base. The surface is one of revolution, an open
/// container's with its cavity; points off the circles (a handle) are added as convex pieces.
Completion CompleteRotational(const CompletionContext& context, const Part& part, double base_m);

/// Other parts: symmetric completion where it applies, strays off the outline left out, then planes
/// square to the table from the outline down to the base. The surface is the convex hull, or, where
/// the outline is not nearly convex, hulls of slices along the longest axis.
Completion CompleteOther(const CompletionContext& context, const Part& part, double base_m);

/// The mirror image (ridges and inclined tops: about the vertical plane through the ridge or the
/// upper edge) or the half-turn image (tops much smaller than the body: about the vertical through
/// the top's centre) of the part's points, without those in space that the sensor saw through or
/// under the table. Empty where neither applies, or where more of the image than the options allow
/// is in space known to be free.
geometry::Points SymmetricImage(const CompletionContext& context, const Part& part);

/// Sets kind, open, top, axis, height, base, box, completed points and surface of an object.
PerceivedObject MakeObject(const CompletionContext& context, const Part& part, double base_m);

}  // namespace rangegrasp::perception
