#pragma once

#include "perception/internal/planar.h"
#include "perception/scene.h"

namespace rangegrasp::perception::internal {

/// An upright axis from the outer wall (two wall points with their normals give a
/// circle, as eq. 5.7); its circle is at the height of the body's
/// top.
std::optional<RotationAxis> AxisFromBody(const PointCloud& cloud, const Indices& points,
                                         const TopSurface& top, const Plane& table,
                                         const FeatureOptions& options, base::Rng& rng);

/// Whether the rim share of the points is on a wall's lip: on the axis' circle or just inside.
bool IsOnLip(const PointCloud& cloud, const Indices& points, const RotationAxis& axis,
             const FeatureOptions& options);

/// Whether the top is such a lip, and fills little of its circle.
bool IsThinRing(const PointCloud& cloud, const TopSurface& top, const RotationAxis& axis,
                const FeatureOptions& options);

/// The axis of a rotational body that lies, from its normals alone: the direction that most
/// of them are square to, and across it the circle that the body is seen as along that direction
/// (as in AxisFromBody). Its body has to agree with the sections as an upright one's (eq. 5.8),
/// goes far enough round, and stays above the table, where half a cylinder on its flat side would
/// be under it.
/// @return nullopt if there is no such direction or the body is not rotational about it.
std::optional<RotationAxis> FindLyingAxis(const PointCloud& cloud, const Indices& points,
                                          const Plane& table, const FeatureOptions& options,
                                          base::Rng& rng);

/// Whether a part is rotational: its rim lies on a circle (first rule) and its body agrees with the
/// circle's axis (second rule; section 5.1.3). Tried with the rim as the alpha shape gives it, then
/// with gaps bridged; with the top plane's normal as the axis, then upright if that is near it.
/// Where the rim gives no circle the axis is taken from the body (AxisFromBody), and that
/// of a lying body from its normals (FindLyingAxis).
/// @return nullopt if it is not rotational.
std::optional<RotationAxis> FindRotationAxis(const PointCloud& cloud, const Indices& points,
                                             const TopSurface& top, const Plane& table,
                                             const FeatureOptions& options, base::Rng& rng);

/// The same of a body that stands, alone.
std::optional<RotationAxis> FindStandingAxis(const PointCloud& cloud, const Indices& points,
                                             const TopSurface& top, const Plane& table,
                                             const FeatureOptions& options, base::Rng& rng);

/// Share of the points on the circle's curve.
double ShareOnCircle(const PointCloud& cloud, const Indices& points, const Circle& circle,
                     double distance_m);

}  // namespace rangegrasp::perception::internal
