#pragma once

#include <cmath>
#include <optional>

#include "geometry/point_cloud.h"

namespace rangegrasp::cylinders {

/// A cylinder of finite height, in the frame of the points that it was fitted to.
struct Cylinder {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< c_g, the center of gravity [m]
  /// v, a unit vector; points out of the end that was seen (up for a standing cylinder).
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  double radius_m = 0.0;
  double height_m = 0.0;

  /// c_m: the center of the end that the axis points out of.
  Eigen::Vector3d Top() const { return center + 0.5 * height_m * axis; }
};

/// A point in cylindrical coordinates about an axis.
struct About {
  About(const Eigen::Vector3d& on_axis, const Eigen::Vector3d& axis, const Eigen::Vector3d& p)
      : along_m((p - on_axis).dot(axis)),
        radial(p - on_axis - along_m * axis),
        radial_m(radial.norm()) {}
  /// Unit vector from the axis to the point.
  Eigen::Vector3d Out() const { return radial / std::max(radial_m, 1e-12); }

  double along_m;  ///< from on_axis
  Eigen::Vector3d radial;
  double radial_m;  ///< distance from the axis
};

struct Line {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();       ///< mean of the fitted points [m]
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< unit; sign arbitrary

  About PlaceOf(const Eigen::Vector3d& p) const { return {point, direction, p}; }
  double Distance(const Eigen::Vector3d& p) const { return PlaceOf(p).radial_m; }
};

/// Two unit vectors perpendicular to a direction and to each other: d = u x v.
struct Across {
  explicit Across(const Eigen::Vector3d& d) : u(d.unitOrthogonal()), v(d.cross(u)) {}
  Eigen::Vector3d u, v;
};

/// p_a = p_b + n_b r (algorithm 1), where the normal points into the body. Normals here face the
/// sensor, out of the body, so that it becomes p_b - n_b r.
inline Eigen::Vector3d AxisPoint(const Eigen::Vector3d& p, const Eigen::Vector3d& outward_normal,
                                 double radius_m) {
  return p - radius_m * outward_normal;
}
/// AxisPoint of all points, with one normal per point.
geometry::Points AxisPoints(geometry::PointSpan barrel, geometry::PointSpan outward_normals,
                            double radius_m);

/// True if a normal is nearer to the radial direction than to the axis: that of a barrel point,
/// from which the axis is calculated (section 4.2.4).
inline bool IsRadial(const Eigen::Vector3d& normal, const Eigen::Vector3d& axis) {
  constexpr double kSquare = 0.7071;  // cos 45 deg
  return std::abs(normal.dot(axis)) <= kSquare;
}

/// The 3-D line fit of algorithm 1: the mean of the points and the eigenvector of the largest
/// eigenvalue of their covariance. O(n).
/// @return nullopt for fewer than two points, or if all points coincide.
std::optional<Line> FitLine(geometry::PointSpan points);

/// FitLine without outliers, which come from normals at the outline or of a neighbor.
std::optional<Line> FitTrimmedLine(geometry::PointSpan points);

/// "Calculation of the circle centre c_m again" (algorithm 1): where the axis meets the plane
/// through the mean of the rim that is perpendicular to `normal` (as published, the table's).
/// @return nullopt if the axis is parallel to the plane or there is no rim.
std::optional<Eigen::Vector3d> CenterOnAxis(const Line& axis, geometry::PointSpan rim,
                                            const Eigen::Vector3d& normal);

/// c_g = c_m - h / 2 v (eq. 4.28).
inline Eigen::Vector3d CenterOfGravity(const Eigen::Vector3d& c_m, const Eigen::Vector3d& v,
                                       double height_m) {
  return c_m - 0.5 * height_m * v;
}

/// True if p is inside the cylinder grown by `grown_m` on all sides.
bool IsWithin(const Cylinder& cylinder, double grown_m, const Eigen::Vector3d& p);
/// Ascending positions of the points within the tolerance of the cylinder's surface. O(n).
geometry::Indices PointsOn(geometry::PointSpan points, const Cylinder& cylinder,
                           double tolerance_m);

// Comparison of the measured rays with a hypothetical cylinder.

/// The point where the ray from `origin` first meets the closed cylinder, as a fraction of `way`
/// (above 1: beyond its end); nullopt if the ray misses it or starts inside.
struct Entry {
  double share = 0.0;
  bool by_end = false;  ///< through an end, not through the barrel
};
std::optional<Entry> EntryOf(const Eigen::Vector3d& origin, const Eigen::Vector3d& way,
                             const Cylinder& cylinder);

/// Rays of a scan, given by the points where they ended.
struct Rays {
  geometry::PointSpan points;
  geometry::PointSpan places;               ///< positions of the sensor
  std::span<const std::uint32_t> place_of;  ///< one per point
};

/// Numbers of measured points, by what their rays say about a cylinder.
struct ViewCounts {
  std::size_t on = 0;       ///< the point is on its surface
  std::size_t before = 0;   ///< an object in front hides the cylinder there
  std::size_t through = 0;  ///< the ray passed through the cylinder's place: it is not there

  std::size_t All() const { return on + before + through; }
  /// Share of the unhidden rays that agree with the cylinder; 0 if there are none.
  double Agreement() const {
    const std::size_t seen = on + through;
    return seen == 0 ? 0.0 : static_cast<double>(on) / static_cast<double>(seen);
  }
};

/// Compares every ray that meets the cylinder with where it should have ended. Rays that enter
/// through an end and end inside are ignored, since a cup is open. O(n).
/// @param tolerance_m  a ray counts as through only if it meets a cylinder that is smaller by this
/// on all sides (with at least half the height)
/// @param left_out  rays that end on its surface are not counted; may be null
ViewCounts CompareWithView(const Rays& rays, const Cylinder& cylinder, double tolerance_m,
                           const Cylinder* left_out = nullptr);

/// The rays of a scan that meet a sphere.
struct RaysThrough {
  RaysThrough(const Rays& all, const Eigen::Vector3d& center, double radius_m);

  /// True if they include all rays that meet `cylinder` or pass it within the tolerance.
  bool AreAllOf(const Cylinder& cylinder, double tolerance_m) const;
  Rays Chosen() const { return {points, places, place_of}; }

  Eigen::Vector3d center;
  double radius_m = 0.0;
  geometry::PointSpan places;
  geometry::Points points;
  geometry::Indices place_of;
};

}  // namespace rangegrasp::cylinders
