#pragma once

#include <algorithm>
#include <utility>

#include "base/statistics.h"
#include "geometry/mesh.h"
#include "perception/perception_options.h"

namespace rangegrasp::perception::internal {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using geometry::Indices;
using geometry::Plane;
using geometry::PointCloud;
using geometry::Points;
using geometry::PointSpan;
using geometry::Select;
using geometry::TriangleMesh;

/// A right-handed frame on a plane: u and v lie in it, n is its normal.
struct PlanarFrame {
  Vector3d origin;
  Vector3d u;
  Vector3d v;
  Vector3d n;

  Vector2d Flat(const Vector3d& p) const { return {(p - origin).dot(u), (p - origin).dot(v)}; }
  double Height(const Vector3d& p) const { return (p - origin).dot(n); }
  Vector3d Lift(const Vector2d& q, double height_m = 0.0) const {
    return origin + q.x() * u + q.y() * v + height_m * n;
  }
};

/// The frame on `plane` under the point `near`, with u along the part of `hint` in the plane (any
/// direction if there is none).
PlanarFrame MakePlanarFrame(const Plane& plane, const Vector3d& near,
                            const Vector3d& hint = Vector3d::Zero());

/// One of two opposite directions, always the same: the one whose largest component is positive.
inline Vector3d WithoutSign(const Vector3d& direction) {
  Eigen::Index main = 0;
  direction.cwiseAbs().maxCoeff(&main);
  return direction[main] < 0.0 ? Vector3d(-direction) : direction;
}

std::vector<Vector2d> Flatten(const PlanarFrame& frame, PointSpan points);

/// The points that fulfil a condition, in their order.
template <typename Holds>
Indices Where(const Indices& points, const Holds& holds) {
  Indices found;
  for (const auto i : points) {
    if (holds(i)) found.push_back(i);
  }
  return found;
}

/// Whether at least a share of the points fulfil a condition.
template <typename Holds>
bool HoldsForShare(double share, const Indices& points, const Holds& holds) {
  return static_cast<double>(std::ranges::count_if(points, holds)) >=
         share * static_cast<double>(points.size());
}

/// The drawn shape that most items agree with, and how many do (RANSAC).
template <typename Draw, typename Items, typename Agrees>
auto BestOfDraws(int draws, const Draw& draw, const Items& items, const Agrees& agrees) {
  std::pair<decltype(draw()), std::size_t> best;  // std::optional of a shape
  for (int k = 0; k < draws; ++k) {
    const auto shape = draw();
    if (!shape) continue;
    const std::size_t count = base::CountToBeat(
        items, best.second, [&](const auto& item) { return agrees(*shape, item); });
    if (count > best.second) best = {shape, count};
  }
  return best;
}

/// A rectangle: its centre, the direction of its longer side, both full sides.
struct Rectangle {
  Vector2d center = Vector2d::Zero();
  Vector2d axis = Vector2d::UnitX();  ///< unit
  double length_m = 0.0;              ///< along axis; >= width_m
  double width_m = 0.0;

  Rectangle LongerSideFirst() const {
    if (width_m <= length_m) return *this;
    return {center, Vector2d(-axis.y(), axis.x()), width_m, length_m};
  }
};

/// The rectangle of least area around a set of points: one of its sides lies on a side of the hull.
/// O(n log n + h^2), h points on the hull.
Rectangle MinAreaRectangle(std::span<const Vector2d> points);

/// The rectangle along the principal axes of the points' covariance (section 5.2).
Rectangle PrincipalRectangle(std::span<const Vector2d> points);

/// The rectangle with sides along `axis` and across it; `axis` stays the rectangle's axis even if
/// it is along the shorter side.
Rectangle RectangleAlong(std::span<const Vector2d> points, const Vector2d& axis);

/// Positions of the points on the convex hull, counter-clockwise (Andrew's monotone chain). If the
/// points are collinear, these are the two ends.
std::vector<std::uint32_t> HullPositions(std::span<const Vector2d> points);

/// The position along v of a fold or an edge along u: the median over 5 mm slices along u of the v
/// of the highest point over the table. Needs a point.
double HighestLine(const PlanarFrame& frame, const Plane& table, PointSpan points);

/// The highest value that has this many others within the band below it, or the highest of all: the
/// end of the measured points without the few mixed points beyond it. O(n log n); needs a value.
double SupportedEnd(std::vector<double> values, std::size_t others, double band_m);

/// The area [m^2] that points in the plane fill, counted in square cells of a grid.
double FilledArea(std::span<const Vector2d> points, double cell_m);

/// The z component of a x b, a and b in the plane.
inline double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// A convex polygon, counter-clockwise, possibly degenerate.
struct ConvexPolygon {
  std::vector<Vector2d> corners;

  static ConvexPolygon Around(std::span<const Vector2d> points);
  double Area() const;
  /// Distance [m] of q from the polygon; 0 inside.
  double Distance(const Vector2d& q) const;
};

/// A circle in the frame of the points it came from.
struct Circle {
  Vector3d center;
  Vector3d normal;  ///< unit; sign arbitrary
  double radius_m = 0.0;
};

/// The circle through three points; nullopt if they are collinear. With u = b - a, v = c - a,
/// w = u x v its centre is a + (|u|^2 v x w + |v|^2 w x u) / (2 |w|^2), which is what eq. 4.18 to
/// 4.21 give.
std::optional<Circle> CircleThrough(const Vector3d& a, const Vector3d& b, const Vector3d& c);

struct CircleFit {
  Circle circle;
  Indices inliers;  ///< ascending positions in the given points
};

/// Distance [m] of p from the curve: the larger of | |q - c| - r | (eq. 5.6, q in the circle's
/// plane) and of p's distance from that plane.
double CircleDistance(const Circle& circle, const Vector3d& p);

/// 3-D circle by RANSAC over 3-point samples: most points with CircleDistance <= the options'
/// distance wins (eq. 5.6, 5.7), then least-squares refits to the inliers. O(draws * n).
/// @return nullopt if no draw gave a circle of an admissible radius.
std::optional<CircleFit> FitCircle(PointSpan rim, const CircleFitOptions& options, base::Rng& rng);

/// The arc [rad] around the circle's axis that the points cover, counted in bins of 10 deg.
double ArcOf(const PointCloud& cloud, const Indices& points, const Circle& circle);

/// Distance [m] of p from the axis through c with unit direction n: |(p - c) x n| (eq. 5.8).
double AxisDistance(const Vector3d& p, const Vector3d& c, const Vector3d& n);

/// The least-squares circle of points in the plane (algebraic, Kasa): centre and radius; nullopt if
/// they are collinear or fewer than three.
struct Circle2 {
  Vector2d center;
  double radius_m = 0.0;
};
std::optional<Circle2> FitCircle2(std::span<const Vector2d> points);

}  // namespace rangegrasp::perception::internal
