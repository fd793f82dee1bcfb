#pragma once

#include <optional>

#include "base/rng.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// The plane normal . p + offset = 0 (eq. 4.1-4.2), normal of unit length.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset_m = 0.0;

  /// Signed distance of p [m], positive on the side the normal points to (eq. 4.3-4.4).
  double Distance(const Eigen::Vector3d& p) const { return normal.dot(p) + offset_m; }
  Eigen::Vector3d Project(const Eigen::Vector3d& p) const { return p - Distance(p) * normal; }
};

/// The plane through three points (eq. 2.4); nullopt if they are collinear.
std::optional<Plane> PlaneThrough(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                  const Eigen::Vector3d& c);

/// Least-squares plane of n >= 3 points (smallest eigenvector of the covariance, eq. 4.12); nullopt
/// if degenerate.
std::optional<Plane> FitPlane(PointSpan points);

/// Whether the points are in one plane: their thickness is below a billionth of their extent. Fewer
/// than three always are.
bool IsFlat(PointSpan points);

struct PlaneRansacOptions {
  int draws = 100;                   ///< >= 1 (section 4.2.1)
  double inlier_distance_m = 0.002;  ///< > 0
};
struct PlaneFit {
  Plane plane;      ///< refitted to all inliers
  Indices inliers;  ///< ascending; within inlier_distance_m of the refitted plane
};
/// 100 hypotheses of three points each; the one with the most points within the distance wins and
/// is refitted (sections 4.2.1, 5.1.1). @return nullopt if no hypothesis was possible.
std::optional<PlaneFit> FitPlaneRansac(PointSpan points, const PlaneRansacOptions& options,
                                       base::Rng& rng);

}  // namespace rangegrasp::geometry
