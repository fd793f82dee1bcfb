#pragma once

#include <cmath>
#include <cstddef>
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

struct Line {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();       ///< the mean of what it was fitted to [m]
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< unit; sign arbitrary

  double Distance(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d offset = p - point;
    return (offset - offset.dot(direction) * direction).norm();
  }
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

/// FitLine without the points that are far from the line, of which normals at the outline or of a
/// neighbor make some. O(n).
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

// Whether what was seen agrees with a cylinder that would stand there.

/// Where the ray from `origin` to `target` first meets the closed cylinder, as a share of the way
/// to the target (so above 1 behind it); nullopt if it misses it or starts inside.
struct Entry {
  double share = 0.0;
  bool by_end = false;  ///< through an end, not through the barrel
};
std::optional<Entry> EntryOf(const Eigen::Vector3d& origin, const Eigen::Vector3d& target,
                             const Cylinder& cylinder);

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
/// @param places  where the sensor stood; place_of: one a point
/// @param tolerance_m  the ray counts as through only if it meets a cylinder smaller by this all
/// round (and not lower than half of it)
/// @param left_out  where not empty, one a point: whether its ray is left out
ViewCounts CompareWithView(geometry::PointSpan points, geometry::PointSpan places,
                           std::span<const std::uint32_t> place_of, const Cylinder& cylinder,
                           double tolerance_m, const std::vector<bool>& left_out = {});

/// Part of the rays of a scan: all that meet a sphere.
struct RaysThrough {
  Eigen::Vector3d center;
  double radius_m = 0.0;
  geometry::Indices chosen;  ///< positions in all points
  geometry::Points points;
  geometry::Indices place_of;

  /// Whether a ray that meets `cylinder`, or passes it within the tolerance, is among them.
  bool AreAllOf(const Cylinder& cylinder, double tolerance_m) const {
    const double bound_m = std::hypot(cylinder.radius_m, 0.5 * cylinder.height_m) + tolerance_m;
    return (cylinder.center - center).norm() + bound_m < radius_m;
  }
};

RaysThrough ChooseRays(geometry::PointSpan points, geometry::PointSpan places,
                       std::span<const std::uint32_t> place_of, const Eigen::Vector3d& center,
                       double radius_m);

/// For each point whether it is on the surface of the closed cylinder, to within the tolerance.
/// O(n).
std::vector<bool> PointsOn(geometry::PointSpan points, const Cylinder& cylinder,
                           double tolerance_m);

}  // namespace rangegrasp::cylinders
