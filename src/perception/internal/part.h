#pragma once

#include <optional>

#include "base/rng.h"
#include "perception/feature_options.h"
#include "perception/internal/sensor_view.h"
#include "perception/scene.h"

namespace rangegrasp::perception::internal {

/// What the steps from segments to objects read.
struct ObjectContext {
  const geometry::PointCloud& cloud;
  const geometry::Plane& table;
  const SensorViews& views;
  const FeatureOptions& options;

  /// Any one place, for the origin of frames on the table.
  const Eigen::Vector3d& FirstOrigin() const { return views.places.front().origin_C(); }
};

/// A part on its way to an object: one segment or several joined, and what was found of it.
struct Part {
  geometry::Indices points;  ///< ascending positions in the cloud
  std::optional<TopSurface> top;
  std::optional<RotationAxis> axis;
};

/// Top surface and rotation axis of a set of points.
Part DescribePart(const ObjectContext& context, geometry::Indices points, base::Rng& rng);

/// The same of the points of both.
Part DescribeUnion(const ObjectContext& context, const Part& a, const Part& b, base::Rng& rng);

}  // namespace rangegrasp::perception::internal
