#pragma once

#include <optional>

#include "core/rng.h"
#include "perception/feature_options.h"
#include "perception/scene.h"

namespace rangegrasp::perception::internal {

/// An upright axis from the outer wall: two wall points with their normals give a center, the one
/// that most wall points agree with wins (as eq. 5.7, with normals in the place of a third point),
/// refitted to all that agree. Its circle is at the height of the body's top. O(draws * n).
/// @return nullopt if the wall has too few points, or too few that agree.
std::optional<RotationAxis> AxisFromBody(const geometry::PointCloud& cloud,
                                         const geometry::Indices& points, const TopSurface& top,
                                         const geometry::Plane& table,
                                         const FeatureOptions& options, core::Rng& rng);

/// Whether the top is the lip of a wall about the axis: its points lie on the circle or just
/// inside, and fill little of it.
bool IsThinRing(const geometry::PointCloud& cloud, const TopSurface& top, const RotationAxis& axis,
                const FeatureOptions& options);

}  // namespace rangegrasp::perception::internal
