#pragma once

#include <optional>

#include "geometry/point_cloud.h"

/// The axis of a cylinder from the normals of its barrel (section 4.2.4, algorithm 1).
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

struct TrimmedLineOptions {
  /// A point further from the line than this many median distances is left out of the next fit: a
  /// normal at the outline or of a neighbor puts it elsewhere. Larger: more of them count.
  double cut = 3.0;
  int rounds = 5;  ///< of leaving out; ends where none changes
};
/// FitLine without the points that are far from the line. O(rounds n).
std::optional<Line> FitTrimmedLine(geometry::PointSpan points,
                                   const TrimmedLineOptions& options = {});

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

}  // namespace rangegrasp::cylinders
