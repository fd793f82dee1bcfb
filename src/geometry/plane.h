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

/// `other`, flipped if needed so that its normal points to the same side as that of `plane`.
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

/// The scatter matrix: the sum of d d^T over the points, where d is the offset from the mean.
Eigen::Matrix3d Scatter(PointSpan points, const Eigen::Vector3d& mean);

/// Whether the points, or fewer than three, are in one plane: thinner than 1e-9 of their extent.
bool IsFlat(PointSpan points);

struct PlaneRansacOptions {
  int draws = 100;                   ///< >= 1 (section 4.2.1)
  double inlier_distance_m = 0.002;  ///< > 0
};
struct PlaneFit {
  Plane plane;      ///< refitted to all inliers
  Indices inliers;  ///< ascending; within inlier_distance_m of the refitted plane
};
/// RANSAC: of `draws` hypotheses of three points each, the one with the most points within the
/// distance is refitted (sections 4.2.1, 5.1.1). @return nullopt if no hypothesis was possible.
std::optional<PlaneFit> FitPlaneRansac(PointSpan points, const PlaneRansacOptions& options,
                                       base::Rng& rng);

/// The neighbors of each point within one radius, kept for a second pass.
struct NeighborLists {
  /// 64 MB. Beyond that the lists of the last points are not kept.
  static constexpr std::size_t kMaxKept = std::size_t{1} << 24;

  double radius_m = 0.0;
  std::vector<std::size_t> ends;  ///< one per point with a kept list: its end in `all`
  Indices all;

  bool Has(std::size_t i) const { return i < ends.size(); }
  std::span<const std::uint32_t> Of(std::size_t i) const {
    const std::size_t first = i == 0 ? 0 : ends[i - 1];
    return {all.data() + first, ends[i] - first};
  }
};

/// Unit normals by principal component analysis of the points within radius_m (section 4.2.2, eq.
/// 4.10-4.12), oriented toward the position from which the point was seen. A point with fewer than
/// three neighbors gets the normal of its nearest three points.
/// @param places  positions of the sensors
/// @param place_of  for each point its index into places; empty: all were seen from the first
/// @param max_radius_m  a collinear neighborhood (of a line scanner on a grazing face) is widened
/// up to this; 0: as published.
/// @param kept  receives the neighbors within radius_m, including the point itself; may be null
Points EstimateNormals(PointSpan points, const KdTree& tree, double radius_m, PointSpan places,
                       std::span<const std::uint32_t> place_of, double max_radius_m = 0.0,
                       NeighborLists* kept = nullptr);

/// Unit normals of points from the faces of a mesh (section 5.1.3): the area-weighted mean of the
/// normals of a point's triangles, each oriented toward the position from which the point was seen.
/// The normal of a point without triangles points to that position.
/// @param triangles  indices into points
Points FaceNormals(PointSpan points, std::span<const std::array<std::uint32_t, 3>> triangles,
                   PointSpan places, std::span<const std::uint32_t> place_of);

}  // namespace rangegrasp::geometry
