#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "base/rng.h"
#include "perception/feature_options.h"
#include "perception/internal/circle.h"
#include "perception/internal/planar.h"
#include "perception/scene.h"

namespace rangegrasp::perception::internal {

/// A point of a body seen along an axis: where it is, and where its normal points to.
struct Wall {
  Eigen::Vector2d p;
  Eigen::Vector2d normal;  ///< unit
};

/// What was seen of the wall about the frame's normal, in the frame.
std::vector<Wall> WallOf(const geometry::PointCloud& cloud, const geometry::Indices& points,
                         const PlanarFrame& frame, const FeatureOptions& options);

/// Whether a point faces away from the center and is on the circle about it.
bool IsOn(const Circle2& circle, const Wall& wall, const FeatureOptions& options);

/// The circle of a body seen along the frame's normal: two wall points with their normals give a
/// center, the one that most wall points agree with wins (as eq. 5.7, with normals in the place of
/// a third point), refitted to all that agree. O(draws * n).
/// @param admissible  circles that may be drawn
/// @return nullopt if the wall has too few points, or too few that agree.
std::optional<Circle2> CircleAcross(const geometry::PointCloud& cloud,
                                    const geometry::Indices& points, const PlanarFrame& frame,
                                    const std::function<bool(const Circle2&)>& admissible,
                                    const FeatureOptions& options, base::Rng& rng);

/// An upright axis from the outer wall by CircleAcross; its circle is at the height of the body's
/// top.
std::optional<RotationAxis> AxisFromBody(const geometry::PointCloud& cloud,
                                         const geometry::Indices& points, const TopSurface& top,
                                         const geometry::Plane& table,
                                         const FeatureOptions& options, base::Rng& rng);

/// Whether the top is a lid on the axis: the rim share of its rim lies within the circle, and what
/// of it lies on the circle goes far enough round.
bool IsLid(const geometry::PointCloud& cloud, const TopSurface& top, const RotationAxis& axis,
           const FeatureOptions& options);

/// Whether the top is the lip of a wall about the axis: its points lie on the circle or just
/// inside, and fill little of it.
bool IsThinRing(const geometry::PointCloud& cloud, const TopSurface& top, const RotationAxis& axis,
                const FeatureOptions& options);

}  // namespace rangegrasp::perception::internal
