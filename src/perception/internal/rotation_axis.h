#pragma once

#include <optional>

#include "base/rng.h"
#include "perception/feature_options.h"
#include "perception/internal/circle.h"
#include "perception/scene.h"

namespace rangegrasp::perception::internal {

/// Whether a part is rotational: its rim lies on a circle (first rule) and its body agrees with the
/// circle's axis (second rule; section 5.1.3). Tried with the rim as the alpha shape gives it, then
/// with gaps bridged; with the top plane's normal as the axis, then upright if that is near it.
/// Where the rim gives no circle the axis is taken from the body (see axis_from_body.h), and that
/// of a lying body from its normals (see lying_axis.h).
/// @return nullopt if it is not rotational.
std::optional<RotationAxis> FindRotationAxis(const geometry::PointCloud& cloud,
                                             const geometry::Indices& points, const TopSurface& top,
                                             const geometry::Plane& table,
                                             const FeatureOptions& options, base::Rng& rng);

/// The same of a body that stands, alone.
std::optional<RotationAxis> FindStandingAxis(const geometry::PointCloud& cloud,
                                             const geometry::Indices& points, const TopSurface& top,
                                             const geometry::Plane& table,
                                             const FeatureOptions& options, base::Rng& rng);

/// Share of the points on the circle's curve.
double ShareOnCircle(const geometry::PointCloud& cloud, const geometry::Indices& points,
                     const Circle& circle, double distance_m);

}  // namespace rangegrasp::perception::internal
