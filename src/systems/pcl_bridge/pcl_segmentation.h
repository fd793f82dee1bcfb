#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/plane.h"
#include "pcl_bridge/cloud.h"

namespace rangegrasp::pcl_bridge {

struct EuclideanClusterOptions {
  /// > 0; points nearer than this belong together. Must exceed the cloud's spacing. Objects nearer
  /// to each other than this become one cluster.
  double tolerance_m = 0.005;
  int min_points = 40;  ///< >= 1; smaller clusters are left out (noise)
};

/// Positions of each cluster's points, ascending; the largest cluster first
/// (EuclideanClusterExtraction). O(n log n).
std::vector<geometry::Indices> EuclideanClusters(const Cloud& cloud,
                                                 const EuclideanClusterOptions& options = {});

/// The default lengths suit points 1 to 2 mm apart and objects of 50 mm or more.
struct LocalConvexityOptions {
  /// > 0. Voxels must be large enough to touch their neighbors on a surface: two to three spacings.
  /// Larger ones blur concave edges. With camera_depth: a voxel's size at a depth of 1 m.
  double voxel_m = 0.005;
  /// > voxel_m. Size of a supervoxel: the smallest object that can be separated, and the area over
  /// which a normal is averaged. Along an edge, half of it can be assigned to the wrong side.
  double seed_m = 0.02;
  /// Voxels grow with the depth z, like the spacing of a camera's points. The cloud's origin must
  /// be the camera and z its viewing direction.
  bool camera_depth = false;
  /// >= 0: segments of at most this many supervoxels join their largest neighbor (the paper: 3).
  int min_supervoxels = 3;
};

struct SupervoxelEdge {
  std::int32_t a = 0;  ///< a < b, positions of neighboring supervoxels
  std::int32_t b = 0;
  bool connects = false;  ///< convex, or concave within the tolerance, and not rejected by a test
};

struct LocalConvexity {
  /// One per point: 0 .. segments - 1, or -1 without a supervoxel.
  std::vector<std::int32_t> segment;
  std::vector<std::int32_t> supervoxel;          ///< one per point: index of a supervoxel, or -1
  std::vector<std::int32_t> supervoxel_segment;  ///< one per supervoxel
  std::vector<SupervoxelEdge> edges;             ///< ascending by (a, b)
  int segments = 0;
};

/// Segments a cloud along its concave edges: supervoxels (Papon et al. 2013, SupervoxelClustering)
/// with convex connections form one segment (Stein et al. 2014, "Object partitioning using local
/// convexity", LCCPSegmentation).
///
/// The library numbers and merges segments in the order of heap addresses, which changes from run
/// to run. Only its verdict on each connection is used; segments are grown, joined (smallest first)
/// and numbered (by descending number of supervoxels) here. O(n log n).
/// @throws std::invalid_argument if with camera_depth a point is not in front of the origin.
LocalConvexity SegmentByLocalConvexity(const Cloud& cloud,
                                       const LocalConvexityOptions& options = {});

struct PlaneOptions {
  int max_draws = 100;               ///< >= 1 (dissertation, section 4.2.1)
  double inlier_distance_m = 0.002;  ///< > 0
  /// (0, 1): drawing ends early when an all-inlier sample has been drawn with this probability,
  /// based on the best share of inliers so far. The library's default.
  double confidence = 0.99;
};

/// The plane with the most points within the distance, by RANSAC, refitted to them by least squares
/// (SACMODEL_PLANE). The library's generator starts from the same state in every call and is
/// single-threaded, so the same input gives the same output. The normal points to the side of the
/// cloud's origin. O(draws n).
/// @return nullopt if no three points span a plane.
std::optional<geometry::PlaneFit> FitPlane(const Cloud& cloud, const PlaneOptions& options = {});

struct Cylinder {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< on the axis [m], nearest to inliers' mean
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit; sign arbitrary
  double radius_m = 0.0;
};

struct CylinderFit {
  Cylinder cylinder;
  geometry::Indices inliers;  ///< ascending
};

struct CylinderOptions {
  /// >= 1. Two points with normals give a hypothesis. If one point in four is on the cylinder,
  /// 1000 draws miss a clean pair with probability (1 - 1/16)^1000 < 1e-28. The large number of
  /// draws is a reserve for noisy normals.
  int max_draws = 1000;
  double inlier_distance_m = 0.002;  ///< > 0; like the plane's
  /// [0, 1]: the distance of a point is the weighted mean w angle + (1 - w) distance of its
  /// normal's angle [rad] and its distance [m] to the cylinder. A larger weight rejects neighboring
  /// surfaces better and tolerates less noise in the normals.
  double normal_weight = 0.01;
  double min_radius_m = 0.005;  ///< >= 0
  double max_radius_m = 0.2;    ///< > min_radius_m
  double confidence = 0.99;     ///< (0, 1), like the plane's
};

/// The cylinder (unbounded along its axis) with the most points within the distance, refitted to
/// them by Levenberg-Marquardt (SACMODEL_CYLINDER). O(draws n).
/// @param normals  of this cloud; points without a normal are never inliers.
/// @return nullopt if no pair of points gave a cylinder with a radius in the range.
/// @throws std::invalid_argument if the number of normals is wrong.
std::optional<CylinderFit> FitCylinder(const Cloud& cloud, const geometry::Points& normals,
                                       const CylinderOptions& options = {});

}  // namespace rangegrasp::pcl_bridge
