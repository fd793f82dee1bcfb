#pragma once

#include "perception/internal/objects.h"

namespace rangegrasp::perception::internal {

/// A ridge: the surface near it curves (or is folded) about `axis` and is highest there.
struct Ridge {
  Vector3d axis;    ///< unit
  Vector3d normal;  ///< unit, across the axis, away from the table
  Vector3d point;   ///< on the ridge
};

/// A ridge needs one direction that the normals of all upward points are perpendicular to, and a
/// wide spread of normals about it. With u the offset across the axis and theta the normal's angle
/// about it, u is fitted by a line over sin(theta). The ridge is at theta = 0, the highest line of
/// a circle, an ellipse or a roof alike.
/// @return nullopt if the upward points form no ridge (RidgeOptions has the conditions).
std::optional<Ridge> FindRidge(const ObjectContext& context, const Indices& segment);

/// The points of the segment whose normals are within the angle of `up`.
Indices UpwardPoints(const PointCloud& cloud, const Indices& segment, const Vector3d& up,
                     double angle_rad);

/// The radius [m] of the sphere of eq. 5.9: the options' factor times the distance from the top
/// surface's center of gravity to the nearest rim point; 0 without a rim.
double OpenSphereRadius(const ObjectContext& context, const TopSurface& top);

/// Open or closed by that sphere in the top surface's center of gravity: open if no point (except
/// for the options' strays) is inside.
bool IsOpen(const ObjectContext& context, const Indices& object, const TopSurface& top);

/// The top surface of a segment: RANSAC plane over the points whose normals are near the table's
/// (eq. 5.5), its principal axis, extents and rim. Takes the strip along the ridge if the top
/// curves about a lying axis, and the highest points if no plane is near enough to the table's
/// inclination (a lying prism), both with `ridge` set.
/// @return nullopt if the segment has fewer than three points or they lie on one line.
std::optional<TopSurface> FindTopSurface(const ObjectContext& context, const Indices& segment,
                                         base::Rng& rng);

/// The highest points as a top surface, even if another plane has more points: a bowl's lip has
/// fewer points than its floor. nullopt if they are a fold.
std::optional<TopSurface> FindLip(const ObjectContext& context, const Indices& segment);

/// The outer boundary of points on a plane by the 2-D alpha shape, in order; positions in the
/// cloud. The convex hull's corners if the alpha shape is empty. One rim per alpha.
std::vector<Indices> OuterRims(const PointCloud& cloud, const Indices& points, const Plane& plane,
                               std::span<const double> alphas_m);

/// The height [m] above the table that a few points reach: the fifth highest, so that a single
/// stray point does not count.
double TopHeight(const PointCloud& cloud, const Indices& points, const Plane& table);

/// The same for the lower end.
double BaseHeight(const PointCloud& cloud, const Indices& points, const Plane& table);

}  // namespace rangegrasp::perception::internal
