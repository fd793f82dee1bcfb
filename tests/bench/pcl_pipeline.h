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
  std::size_t points = 0;  ///< that filter, normals and clusters worked on
  std::size_t found_clusters = 0;

  double Sum() const { return plane + filter + normals + clusters; }
};

/// The plane on all points; the rest on the points above it or, with `whole_cloud`, on all of them.
/// Not counted is the conversion of the points, once at the start.
/// @throws std::runtime_error if there is no plane.
PclSeconds RunPcl(geometry::PointSpan points, const Eigen::Vector3d& sensor_origin,
                  bool whole_cloud);

}  // namespace rangegrasp::bench
