#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/point_cloud.h"

/// Functions of the Point Cloud Library. Points that are not finite are left out; indices and
/// labels are positions in the points given. `origin` is the sensor's position [m] in their frame.
/// All throw std::invalid_argument if it is not finite.

namespace rangegrasp::pcl_bridge {

/// Normals by principal component analysis of the points within the radius (NormalEstimation),
/// O(n log n).
/// @param radius_m  > 0. A larger radius smooths noise and rounds edges. 5 mm in section 5.1.1.
/// @return one unit vector per point, towards the origin; NaN if fewer than three points are within
///         the radius or the point itself is not finite.
geometry::Points EstimateNormals(geometry::PointSpan points, const Eigen::Vector3d& origin,
                                 double radius_m = 0.005);

struct EuclideanClusterOptions {
  /// > 0; points nearer than this belong together. Must exceed the cloud's spacing. Objects nearer
  /// to each other than this become one cluster.
  double tolerance_m = 0.005;
  int min_points = 40;  ///< >= 1; smaller clusters are left out (noise)
};

/// Positions of each cluster's points, ascending; the largest cluster first
/// (EuclideanClusterExtraction). O(n log n).
std::vector<geometry::Indices> EuclideanClusters(geometry::PointSpan points,
                                                 const Eigen::Vector3d& origin,
                                                 const EuclideanClusterOptions& options = {});

/// The default lengths suit points 1 to 2 mm apart and objects of 50 mm or more.
struct LocalConvexityOptions {
  /// > 0. Voxels must be large enough to touch their neighbors on a surface: two to three spacings.
  /// Larger ones blur concave edges. With camera_depth: a voxel's size at a depth of 1 m.
  double voxel_m = 0.005;
  /// > voxel_m. Size of a supervoxel: the smallest object that can be separated, and the area over
  /// which a normal is averaged. Along an edge, half of it can be assigned to the wrong side.
  double seed_m = 0.02;
  /// Voxels grow with the depth z, like the spacing of a camera's points. The origin must be the
  /// camera and z its viewing direction.
  bool camera_depth = false;
  /// >= 0: segments of at most this many supervoxels join their largest neighbor (the paper: 3).
  int min_supervoxels = 3;
};

/// Segments a cloud along its concave edges: supervoxels (Papon et al. 2013, SupervoxelClustering)
/// with convex connections form one segment (Stein et al. 2014, "Object partitioning using local
/// convexity", LCCPSegmentation).
///
/// The library numbers and merges segments in the order of heap addresses, which changes from run
/// to run. Only its verdict on each connection is used; segments are grown, joined (smallest first)
/// and numbered (by descending number of supervoxels) here. O(n log n).
/// @return one per point: its segment, or -1 without a supervoxel.
/// @throws std::invalid_argument if with camera_depth a point is not in front of the origin.
std::vector<std::int32_t> SegmentByLocalConvexity(geometry::PointSpan points,
                                                  const Eigen::Vector3d& origin,
                                                  const LocalConvexityOptions& options = {});

struct CylinderFit {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< on the axis [m], nearest to inliers' mean
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit; sign arbitrary
  double radius_m = 0.0;
  geometry::Indices inliers;  ///< ascending
};

struct CylinderOptions {
  /// >= 1. Two points with normals give a hypothesis. If one point in four is on the cylinder,
  /// 1000 draws miss a clean pair with probability (1 - 1/16)^1000 < 1e-28. The large number of
  /// draws is a reserve for noisy normals.
  int max_draws = 1000;
  double inlier_distance_m = 0.002;  ///< > 0
  /// [0, 1]: the distance of a point is the weighted mean w angle + (1 - w) distance of its
  /// normal's angle [rad] and its distance [m] to the cylinder. A larger weight rejects neighboring
  /// surfaces better and tolerates less noise in the normals.
  double normal_weight = 0.01;
  double min_radius_m = 0.005;  ///< >= 0
  double max_radius_m = 0.2;    ///< > min_radius_m
};

/// The cylinder (unbounded along its axis) with the most points within the distance, refitted to
/// them by Levenberg-Marquardt (SACMODEL_CYLINDER). The library's generator starts from the same
/// state in every call and is single-threaded, so the same input gives the same output. O(draws n).
/// @param normals  of these points; points without a normal are never inliers.
/// @return nullopt if no pair of points gave a cylinder with a radius in the range.
/// @throws std::invalid_argument if the number of normals is wrong.
std::optional<CylinderFit> FitCylinder(geometry::PointSpan points, const Eigen::Vector3d& origin,
                                       const geometry::Points& normals,
                                       const CylinderOptions& options = {});

}  // namespace rangegrasp::pcl_bridge
