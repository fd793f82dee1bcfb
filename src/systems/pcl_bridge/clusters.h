#pragma once

#include <vector>

#include "base/units.h"
#include "pcl_bridge/cloud.h"
#include "pcl_bridge/surface_normals.h"

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

struct RegionGrowingOptions {
  int neighbors = 30;  ///< >= 1, itself among them; a region grows to these of a point
  /// (0, pi / 2]: between a point's normal and its neighbor's. The library's tutorial takes 3
  /// degrees.
  double max_angle_rad = 3.0 * base::kDeg;
  /// > 0: a point whose surface variation exceeds it joins a region but does not carry it on.
  double max_curvature = 0.05;
  int min_points = 40;  ///< >= 1; smaller regions are left out
};

/// Positions of each smooth region's points, ascending; regions in the order in which they were
/// grown, from the flattest seed on (RegionGrowing). Points without a normal are in none. O(n log
/// n).
/// @param normals  of this cloud.
/// @throws std::invalid_argument if an option is out of range or the normals are not the cloud's.
std::vector<geometry::Indices> GrowRegions(const Cloud& cloud, const Normals& normals,
                                           const RegionGrowingOptions& options = {});

}  // namespace rangegrasp::pcl_bridge
