#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "base/rng.h"
#include "geometry/kd_tree.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// The plane normal . p + offset = 0 (eq. 4.1-4.2), normal of unit length.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset_m = 0.0;

  /// Signed distance of p [m], positive on the side the normal points to (eq. 4.3-4.4).
  double Distance(const Eigen::Vector3d& p) const { return normal.dot(p) + offset_m; }
  Eigen::Vector3d Project(const Eigen::Vector3d& p) const { return p - Distance(p) * normal; }
  Plane Flipped() const { return {-normal, -offset_m}; }
};

/// `other` with its normal on the side of the plane's.
inline Plane TurnedLike(const Plane& plane, const Plane& other) {
  return other.normal.dot(plane.normal) < 0.0 ? other.Flipped() : other;
}

/// The plane through p with a unit normal.
inline Plane PlaneAt(const Eigen::Vector3d& normal, const Eigen::Vector3d& p) {
  return {normal, -normal.dot(p)};
}

/// The plane through three points (eq. 2.4); nullopt if they are collinear.
std::optional<Plane> PlaneThrough(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                  const Eigen::Vector3d& c);

/// Least-squares plane of n >= 3 points (eq. 4.12); nullopt if degenerate.
std::optional<Plane> FitPlane(PointSpan points);

/// The sum of d d^T over the points, d from the mean.
Eigen::Matrix3d Scatter(PointSpan points, const Eigen::Vector3d& mean);

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

/// The neighbors of each point within one radius, kept for a second pass.
struct NeighborLists {
  /// 64 MB. Beyond that the lists of the last points are not kept.
  static constexpr std::size_t kMaxKept = std::size_t{1} << 24;

  double radius_m = 0.0;
  std::vector<std::size_t> ends;  ///< one a point whose list is kept: where it ends in `all`
  Indices all;

  bool Has(std::size_t i) const { return i < ends.size(); }
  std::span<const std::uint32_t> Of(std::size_t i) const {
    const std::size_t first = i == 0 ? 0 : ends[i - 1];
    return {all.data() + first, ends[i] - first};
  }
};

/// Unit normals by principal components of the points within radius_m (section 4.2.2,
/// eq. 4.10-4.12), turned to the side of the place that the point was seen from. A point with fewer
/// than three neighbors takes the normal of its nearest three.
/// @param places  where the sensors stood
/// @param place_of  one a point: position in places
/// @param max_radius_m  a neighborhood on a line (a line scanner's on a grazing face) is widened up
/// to this; 0: as published.
/// @param kept  receives the neighbors within radius_m, each point among its own; may be null
Points EstimateNormals(PointSpan points, const KdTree& tree, double radius_m, PointSpan places,
                       std::span<const std::uint32_t> place_of, double max_radius_m = 0.0,
                       NeighborLists* kept = nullptr);
/// The same where all points were seen from one place.
Points EstimateNormals(PointSpan points, const KdTree& tree, double radius_m,
                       const Eigen::Vector3d& origin);

/// Unit normals of the faces of a mesh (section 5.1.3): each triangle's turned to the side of the
/// place that a point was seen from, and a point's the mean of those that it is a corner of,
/// weighted by their areas. A point of no triangle faces the place that it was seen from.
/// @param triangles  positions in points
Points FaceNormals(PointSpan points, std::span<const std::array<std::uint32_t, 3>> triangles,
                   PointSpan places, std::span<const std::uint32_t> place_of);

}  // namespace rangegrasp::geometry
