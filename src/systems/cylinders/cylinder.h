#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "geometry/point_cloud.h"

namespace rangegrasp::cylinders {

/// A cylinder with its ends, in the frame of the points it came from.
struct Cylinder {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< c_g, the centre of gravity [m]
  /// v, unit; out of the end that was seen: up where it stands.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  double radius_m = 0.0;
  double height_m = 0.0;

  /// c_m: the middle of the end that the axis points out of.
  Eigen::Vector3d Top() const { return center + 0.5 * height_m * axis; }
};

/// A point in the coordinates of an axis.
struct About {
  About(const Eigen::Vector3d& on_axis, const Eigen::Vector3d& axis, const Eigen::Vector3d& p)
      : along_m((p - on_axis).dot(axis)),
        radial(p - on_axis - along_m * axis),
        radial_m(radial.norm()) {}
  /// Unit, from the axis to the point.
  Eigen::Vector3d Out() const { return radial / std::max(radial_m, 1e-12); }

  double along_m;  ///< from on_axis
  Eigen::Vector3d radial;
  double radial_m;  ///< distance from the axis
};

struct Line {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();       ///< the mean of what it was fitted to [m]
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< unit; sign arbitrary

  About PlaceOf(const Eigen::Vector3d& p) const { return {point, direction, p}; }
  double Distance(const Eigen::Vector3d& p) const { return PlaceOf(p).radial_m; }
};

/// Two unit vectors square to a direction and to each other: d = u x v.
struct Across {
  explicit Across(const Eigen::Vector3d& d) : u(d.unitOrthogonal()), v(d.cross(u)) {}
  Eigen::Vector3d u, v;
};

/// p_a = p_b + n_b r (algorithm 1) with the normal turned into the body: normals here face the
/// sensor, out of the body, so that it is p_b - n_b r.
inline Eigen::Vector3d AxisPoint(const Eigen::Vector3d& p, const Eigen::Vector3d& outward_normal,
                                 double radius_m) {
  return p - radius_m * outward_normal;
}
/// The same of all points. @throws std::invalid_argument unless there is one normal a point.
geometry::Points AxisPoints(geometry::PointSpan barrel, geometry::PointSpan outward_normals,
                            double radius_m);

/// The 3-D line fit of algorithm 1: the mean of the points and the eigenvector of the largest
/// eigenvalue of their covariance. O(n).
/// @return nullopt for fewer than two points, or where they are all one.
std::optional<Line> FitLine(geometry::PointSpan points);

/// FitLine without points far from the line, which normals at the outline or of a neighbor make.
std::optional<Line> FitTrimmedLine(geometry::PointSpan points);

/// c_m again, on the axis ("calculation of the circle centre c_m again", algorithm 1): where the
/// line passes the plane square to `normal` (as published the table's) through the mean of the rim.
/// @return nullopt if the line runs within the plane or there is no rim.
std::optional<Eigen::Vector3d> CenterOnAxis(const Line& axis, geometry::PointSpan rim,
                                            const Eigen::Vector3d& normal);

/// c_g = c_m - h / 2 v (eq. 4.28).
inline Eigen::Vector3d CenterOfGravity(const Eigen::Vector3d& c_m, const Eigen::Vector3d& v,
                                       double height_m) {
  return c_m - 0.5 * height_m * v;
}

/// Whether p is inside the cylinder grown by so much all round.
bool IsWithin(const Cylinder& cylinder, double grown_m, const Eigen::Vector3d& p);
/// Ascending positions of the points on its surface, to within the tolerance. O(n).
geometry::Indices PointsOn(geometry::PointSpan points, const Cylinder& cylinder,
                           double tolerance_m);

// Whether what was seen agrees with a cylinder that would stand there.

/// Where the ray from `origin` first meets the closed cylinder, as a share of `way` (so above 1
/// behind its end); nullopt if it misses it or starts inside.
struct Entry {
  double share = 0.0;
  bool by_end = false;  ///< through an end, not through the barrel
};
std::optional<Entry> EntryOf(const Eigen::Vector3d& origin, const Eigen::Vector3d& way,
                             const Cylinder& cylinder);

/// Rays of a scan by the points where they ended.
struct Rays {
  geometry::PointSpan points;
  geometry::PointSpan places;               ///< where the sensor stood
  std::span<const std::uint32_t> place_of;  ///< one a point
};

/// Measured points by what their ray says of a cylinder.
struct ViewCounts {
  std::size_t on = 0;       ///< the point is on its surface
  std::size_t before = 0;   ///< something in front hides it there
  std::size_t through = 0;  ///< the ray went through where the cylinder would be: it is not there

  std::size_t All() const { return on + before + through; }
  /// Share of the rays not hidden that agree; 0 if there are none.
  double Agreement() const {
    const std::size_t seen = on + through;
    return seen == 0 ? 0.0 : static_cast<double>(on) / static_cast<double>(seen);
  }
};

/// Compares every ray that meets the cylinder with where it should have ended. A ray that enters by
/// an end and ends inside says nothing: a cup is open. O(n).
/// @param tolerance_m  the ray counts as through only if it meets a cylinder smaller by this all
/// round (and not lower than half of it)
/// @param left_out  rays that end on its surface do not count; may be null
ViewCounts CompareWithView(const Rays& rays, const Cylinder& cylinder, double tolerance_m,
                           const Cylinder* left_out = nullptr);

/// Part of the rays of a scan: all that meet a sphere.
struct RaysThrough {
  RaysThrough(const Rays& all, const Eigen::Vector3d& center, double radius_m);

  /// Whether a ray that meets `cylinder`, or passes it within the tolerance, is among them.
  bool AreAllOf(const Cylinder& cylinder, double tolerance_m) const;
  Rays Chosen() const { return {points, places, place_of}; }

  Eigen::Vector3d center;
  double radius_m = 0.0;
  geometry::PointSpan places;
  geometry::Points points;
  geometry::Indices place_of;
};

}  // namespace rangegrasp::cylinders
