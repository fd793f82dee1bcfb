#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/units.h"
#include "geometry/plane.h"
#include "pcl_bridge/cloud.h"

namespace rangegrasp::pcl_bridge {

struct EuclideanClusterOptions {
  /// > 0; points nearer than this are together. Must exceed the cloud's spacing; bodies nearer than
  /// this come out as one.
  double tolerance_m = 0.005;
  int min_points = 40;  ///< >= 1; smaller clusters are left out (noise)
};

/// Positions of each cluster's points, ascending; the largest cluster first
/// (EuclideanClusterExtraction). O(n log n).
/// @throws std::invalid_argument if an option is out of range.
std::vector<geometry::Indices> EuclideanClusters(const Cloud& cloud,
                                                 const EuclideanClusterOptions& options = {});

/// Lengths suit points 1 to 2 mm apart and objects of 50 mm or more.
struct LocalConvexityOptions {
  /// > 0. Voxels must be large enough to touch their neighbors on a surface: two to three spacings.
  /// Larger blurs concave edges. With camera_depth: a voxel's size at a depth of 1 m.
  double voxel_m = 0.005;
  /// > voxel_m. A supervoxel's size: the smallest thing that is separated, and the area over
  /// which a normal is averaged. Along an edge half of it can go to the wrong side.
  double seed_m = 0.02;
  /// Voxels that grow with the depth z, as the spacing of a camera's points does. Needs the
  /// cloud's origin at the camera and z along its view.
  bool camera_depth = false;
  /// [0, pi]: a concave connection whose normals differ by less than this still connects (Stein et
  /// al. 2014: 10 degrees). Larger joins across shallow creases, smaller breaks surfaces at noise.
  double concavity_tolerance_rad = 10.0 * base::kDeg;
  /// >= 0, in supervoxels: segments of at most so many join their largest neighbor (the paper: 3).
  int min_supervoxels = 3;
};

struct SupervoxelEdge {
  std::int32_t a = 0;  ///< a < b, positions of neighboring supervoxels
  std::int32_t b = 0;
  bool connects = false;  ///< convex, or concave within the tolerance, and no test left it out
};

struct LocalConvexity {
  /// One a point: 0 .. segments - 1, or -1 where no supervoxel grew.
  std::vector<std::int32_t> segment;
  std::vector<std::int32_t> supervoxel;          ///< one a point: a number of a supervoxel, or -1
  std::vector<std::int32_t> supervoxel_segment;  ///< one a supervoxel
  std::vector<SupervoxelEdge> edges;             ///< ascending by (a, b)
  int segments = 0;
};

/// Cuts a cloud along its concave edges: supervoxels (Papon et al. 2013, SupervoxelClustering) that
/// are connected convexly are one segment (Stein et al. 2014, "Object partitioning using local
/// convexity", LCCPSegmentation).
///
/// The library numbers and merges segments in the order of addresses on the heap, which changes
/// from run to run. Only its verdict on each connection is taken; segments are grown, joined
/// (smallest first) and numbered (by descending count of supervoxels) here. O(n log n).
/// @throws std::invalid_argument if an option is out of range, or with camera_depth a point is not
///         in front of the origin.
LocalConvexity SegmentByLocalConvexity(const Cloud& cloud,
                                       const LocalConvexityOptions& options = {});

struct PlaneOptions {
  int max_draws = 100;               ///< >= 1 (dissertation, section 4.2.1)
  double inlier_distance_m = 0.002;  ///< > 0
  /// (0, 1): drawing ends early once a sample of inliers alone was drawn with this probability,
  /// were the share of inliers the best one found. The library's own value.
  double confidence = 0.99;
};

/// The plane with the most points within the distance, by RANSAC, refitted to them by least squares
/// (SACMODEL_PLANE). The library draws from a generator that starts from the same state in every
/// call, single-threaded: the same input gives the same output. Its normal points to the side of
/// the cloud's origin. O(draws n).
/// @return nullopt if no three points span a plane.
/// @throws std::invalid_argument if an option is out of range.
std::optional<geometry::PlaneFit> FitPlane(const Cloud& cloud, const PlaneOptions& options = {});

struct Cylinder {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< on the axis [m], next to the inliers' mean
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit; sign arbitrary
  double radius_m = 0.0;
};

struct CylinderFit {
  Cylinder cylinder;
  geometry::Indices inliers;  ///< ascending
};

struct CylinderOptions {
  /// >= 1. Two points with normals make a hypothesis; where one point in four is on the cylinder,
  /// 1000 draws miss a clean pair with probability (1 - 1/16)^1000 < 1e-28: the rest is for noisy
  /// normals.
  int max_draws = 1000;
  double inlier_distance_m = 0.002;  ///< > 0; as the plane's
  /// [0, 1]: the distance of a point is the weighted mean w angle + (1 - w) distance of its
  /// normal's angle [rad] and its place's distance [m] to the cylinder. Larger throws out
  /// neighboring surfaces sooner and tolerates less noise in the normals.
  double normal_weight = 0.01;
  double min_radius_m = 0.005;  ///< >= 0
  double max_radius_m = 0.2;    ///< > min_radius_m
  double confidence = 0.99;     ///< (0, 1), as the plane's
};

/// The cylinder (unbounded along its axis) with the most points within the distance, refitted to
/// them by Levenberg-Marquardt (SACMODEL_CYLINDER). O(draws n).
/// @param normals  of this cloud; points without one are no inliers.
/// @return nullopt if no pair of points made a cylinder with a radius in the range.
/// @throws std::invalid_argument if an option is out of range or the normals are not the cloud's.
std::optional<CylinderFit> FitCylinder(const Cloud& cloud, const geometry::Points& normals,
                                       const CylinderOptions& options = {});

}  // namespace rangegrasp::pcl_bridge
