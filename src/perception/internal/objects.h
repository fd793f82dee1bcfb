#pragma once

#include "perception/internal/planar.h"
#include "perception/internal/sensor_view.h"

namespace rangegrasp::perception::internal {

/// Input of the steps from segments to objects.
struct ObjectContext {
  const PointCloud& cloud;
  const Plane& table;
  const SensorViews& views;
  const FeatureOptions& options;

  /// Any one of the sensors' places, for the origin of frames on the table.
  const Vector3d& FirstOrigin() const { return views.places.front().origin_C(); }
};

/// A candidate for an object: one segment or several joined ones, and their features.
struct Part {
  Indices points;  ///< ascending positions in the cloud
  std::optional<TopSurface> top;
  std::optional<RotationAxis> axis;
};

/// Sets center_C, size_m and axis_C: the box around completed_C, from base_m to height_m.
/// @param frame  on the table
void SetBox(const PlanarFrame& frame, const CompletionOptions& options, PerceivedObject& object);

/// Top surface and refined rotation axis of a set of points.
Part DescribePart(const ObjectContext& context, Indices points, base::Rng& rng);

/// The same for the points of both.
Part DescribeUnion(const ObjectContext& context, const Part& a, const Part& b, base::Rng& rng);

/// Sections 5.1.3 and 5.1.4 over all segments: top surfaces, circles, merging of clipped rotational
/// parts and of fragments, completion, and order: topmost first, to the millimetre, then larger
/// first. Appends the seconds of its steps.
/// @param segments  none is empty; positions in the cloud, each ascending
std::vector<PerceivedObject> BuildObjects(const ObjectContext& context,
                                          const std::vector<Indices>& segments, base::Rng& rng,
                                          StageSeconds& seconds);

}  // namespace rangegrasp::perception::internal
