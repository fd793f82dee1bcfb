#pragma once

#include <cstdint>
#include <vector>

#include "base/units.h"
#include "pcl_bridge/cloud.h"

namespace rangegrasp::pcl_bridge {

/// Lengths suit points 1 to 2 mm apart and objects of 50 mm or more.
struct LocalConvexityOptions {
  /// > 0. Voxels must be large enough to touch their neighbors on a surface: two to three spacings.
  /// Larger blurs concave edges. With camera_depth: a voxel's size at a depth of 1 m.
  double voxel_m = 0.005;
  /// > voxel_m. A supervoxel's size: the smallest thing that can be told apart, and the area over
  /// which a normal is averaged. Along an edge half of it can go to the wrong side.
  double seed_m = 0.02;
  /// Voxels that grow with the depth z, as the spacing of a camera's points does. Needs the
  /// cloud's origin at the camera and z along its view.
  bool camera_depth = false;
  /// How supervoxels grow, both >= 0: (1 - |cos| of the angle between normals) and distance /
  /// seed_m are added with these weights, the library's own.
  double normal_importance = 1.0;
  double spatial_importance = 0.4;
  /// [0, pi]: a concave connection whose normals differ by less than this still connects (Stein et
  /// al. 2014: 10 degrees). Larger joins across shallow creases, smaller breaks surfaces at noise.
  double concavity_tolerance_rad = 10.0 * base::kDeg;
  /// A convex connection must have this many common neighbors that are connected convexly with both
  /// ends ("extended convexity", 1 in the paper); 0 leaves the test out. Together with sanity_check
  /// it broke convex boxes at their corners (scans of local_convexity_test.cpp: 40 % of a face
  /// lost).
  int common_neighbors = 0;
  /// Leaves out connections at which supervoxels touch in a point only (the paper's sanity
  /// criterion). Without it or common_neighbors, six of ten pairs of touching boxes came out as one
  /// there.
  bool sanity_check = true;
  /// Leaves out connections across a step: planes further apart than their angle explains by more
  /// than this many voxels (the library's 0.1). 0 leaves the test out.
  double step_voxels = 0.1;
  /// >= 0, in supervoxels: segments of at most so many join their largest neighbor (the paper: 3).
  int min_supervoxels = 3;
};

struct Supervoxel {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< mean of its voxels [m]
  Eigen::Vector3d normal =
      Eigen::Vector3d::Zero();  ///< unit, towards the cloud's origin; NaN of specks
  std::int32_t segment = 0;
};

struct SupervoxelEdge {
  std::int32_t a = 0;  ///< a < b, positions of neighboring supervoxels
  std::int32_t b = 0;
  bool connects = false;  ///< convex, or concave within the tolerance, and no test left it out
};

struct LocalConvexity {
  std::vector<std::int32_t>
      segment;  ///< one a point: 0 .. segments - 1, or -1 where no supervoxel grew
  std::vector<std::int32_t> supervoxel;  ///< one a point: a position in supervoxels, or -1
  std::vector<Supervoxel> supervoxels;
  std::vector<SupervoxelEdge> edges;  ///< ascending by (a, b)
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
/// in
///         front of the origin.
LocalConvexity SegmentByLocalConvexity(const Cloud& cloud,
                                       const LocalConvexityOptions& options = {});

}  // namespace rangegrasp::pcl_bridge
