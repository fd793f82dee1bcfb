#pragma once

#include "perception/internal/objects.h"

namespace rangegrasp::perception::internal {

/// An upright axis from the outer wall: two wall points with their normals give a circle (as in eq.
/// 5.7). The circle is at the height of the body's top.
std::optional<RotationAxis> AxisFromBody(const ObjectContext& context, const Indices& points,
                                         const TopSurface& top, base::Rng& rng);

/// Whether the rim share of the points is on a wall's lip: on the axis' circle or just inside it.
bool IsOnLip(const ObjectContext& context, const Indices& points, const RotationAxis& axis);

/// Whether the top is such a lip and fills little of its circle.
bool IsThinRing(const ObjectContext& context, const TopSurface& top, const RotationAxis& axis);

/// The axis of a lying rotational body, from its normals alone: the direction that most of them are
/// perpendicular to, and the circle of the body seen along that direction (as in AxisFromBody). The
/// body has to agree with the sections like an upright one (eq. 5.8), cover a large enough arc, and
/// stay above the table; half a cylinder on its flat side would extend below it.
/// @return nullopt if there is no such direction or the body is not rotational about it.
std::optional<RotationAxis> FindLyingAxis(const ObjectContext& context, const Indices& points,
                                          base::Rng& rng);

/// Whether a part is rotational: its rim lies on a circle (first rule) and its body agrees with the
/// circle's axis (second rule; section 5.1.3). It is tried with the rim of the alpha shape, then
/// with bridged gaps; with the top plane's normal as the axis, then upright if that is near it. If
/// the rim gives no circle, the axis is taken from the body (AxisFromBody), and that of a lying
/// body from its normals (FindLyingAxis).
/// @return an axis that is not refined (RefineAxis); nullopt if the part is not rotational.
std::optional<RotationAxis> FindRotationAxis(const ObjectContext& context, const Indices& points,
                                             const TopSurface& top, base::Rng& rng);

/// The same for a standing body only.
std::optional<RotationAxis> FindStandingAxis(const ObjectContext& context, const Indices& points,
                                             const TopSurface& top, base::Rng& rng);

/// Share of the points on the circle's curve.
double ShareOnCircle(const PointCloud& cloud, const Indices& points, const Circle& circle,
                     double distance_m);

}  // namespace rangegrasp::perception::internal
