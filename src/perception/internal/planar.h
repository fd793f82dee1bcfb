#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/plane.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::perception::internal {

/// A right-handed frame on a plane: u and v in it, n its normal.
struct PlanarFrame {
  Eigen::Vector3d origin;
  Eigen::Vector3d u;
  Eigen::Vector3d v;
  Eigen::Vector3d n;

  Eigen::Vector2d Flat(const Eigen::Vector3d& p) const {
    return {(p - origin).dot(u), (p - origin).dot(v)};
  }
  Eigen::Vector3d Lift(const Eigen::Vector2d& q, double height_m = 0.0) const {
    return origin + q.x() * u + q.y() * v + height_m * n;
  }
};

/// The frame on `plane` under the point `near`, with u along `hint` as far as that lies in the
/// plane (any direction where it does not).
PlanarFrame MakePlanarFrame(const geometry::Plane& plane, const Eigen::Vector3d& near,
                            const Eigen::Vector3d& hint = Eigen::Vector3d::Zero());

std::vector<Eigen::Vector2d> Flatten(const PlanarFrame& frame, geometry::PointSpan points);

/// A rectangle: its centre, the direction of its longer side, both full sides.
struct Rectangle {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  Eigen::Vector2d axis = Eigen::Vector2d::UnitX();  ///< unit
  double length_m = 0.0;                            ///< along axis; >= width_m
  double width_m = 0.0;
};

/// The rectangle of least area round a set of points: one of its sides lies on a side of the
/// hull. O(n log n + h^2), h points on the hull.
Rectangle MinAreaRectangle(std::span<const Eigen::Vector2d> points);

/// The rectangle along the principal axes of the points' covariance (section 5.2).
Rectangle PrincipalRectangle(std::span<const Eigen::Vector2d> points);

/// The rectangle with sides along `axis` and across it; `axis` stays the rectangle's even where it
/// is the shorter side.
Rectangle RectangleAlong(std::span<const Eigen::Vector2d> points, const Eigen::Vector2d& axis);

/// Positions of the points on the convex hull, counter-clockwise (Andrew's monotone chain). All
/// points come back, in order along the line, where they are collinear.
std::vector<std::uint32_t> HullPositions(std::span<const Eigen::Vector2d> points);

/// Where, along the frame's v, the highest points over the table are: the median over 5 mm slices
/// along u of the highest point's v. The line of a fold or an edge that runs along u. Needs a
/// point.
double HighestLine(const PlanarFrame& frame, const geometry::Plane& table,
                   geometry::PointSpan points);

/// The highest value that has so many others within the band below it, or the highest of all: the
/// end of what was measured without the few mixed points beyond it. O(n log n); needs a value.
double SupportedEnd(std::vector<double> values, std::size_t others, double band_m);

/// The area [m^2] that points in the plane fill, counted in square cells of a grid.
double FilledArea(std::span<const Eigen::Vector2d> points, double cell_m);

/// The z component of a x b, a and b in the plane.
inline double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// A convex polygon, counter-clockwise, possibly degenerate.
struct ConvexPolygon {
  std::vector<Eigen::Vector2d> corners;

  static ConvexPolygon Around(std::span<const Eigen::Vector2d> points);
  double Area() const;
  /// Distance [m] of q from the polygon; 0 inside.
  double Distance(const Eigen::Vector2d& q) const;
};

}  // namespace rangegrasp::perception::internal
