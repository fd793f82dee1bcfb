#pragma once

#include <cstddef>

#include "geometry/point_cloud.h"

namespace rangegrasp::bench {

/// Seconds of the Point Cloud Library's counterparts to perception's first steps, serial like ours.
struct PclSeconds {
  double plane = 0.0;      ///< pcl_bridge::FitPlane: at most 100 draws, 2 mm, refined
  double filter = 0.0;     ///< StatisticalFilter, 50 neighbors
  double normals = 0.0;    ///< EstimateNormals, radius 5 mm
  double clusters = 0.0;   ///< EuclideanClusters, 5 mm
  std::size_t points = 0;  ///< input of filter, normals and clusters
  std::size_t found_clusters = 0;

  double Sum() const { return plane + filter + normals + clusters; }
};

/// Fits the plane to all points. The other steps use the points above it or, with `whole_cloud`,
/// all points. The conversion of the points, once at the start, is not counted.
/// @throws std::runtime_error if there is no plane.
PclSeconds RunPcl(geometry::PointSpan points, const Eigen::Vector3d& sensor_origin,
                  bool whole_cloud);

}  // namespace rangegrasp::bench
