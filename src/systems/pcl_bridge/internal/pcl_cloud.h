#pragma once

#include <pcl/PointIndices.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <stdexcept>

#include "geometry/point_cloud.h"

namespace rangegrasp::pcl_bridge {

using PclCloud = pcl::PointCloud<pcl::PointXYZ>;

/// The finite points of a cloud in the library's format: in single precision, relative to `origin`,
/// the viewpoint. The library orients normals towards zero, and floats are most precise there (0.06
/// um at 1 m).
struct FinitePoints {
  /// The first one in a process permanently silences the library's console messages. The results
  /// here contain the same information.
  /// @throws std::invalid_argument if origin is not finite.
  FinitePoints(geometry::PointSpan points, const Eigen::Vector3d& origin);

  PclCloud::Ptr points{new PclCloud};
  geometry::Indices source;  ///< their positions in the points given, ascending
};

/// Converts the library's indices to positions in the points given; ascending.
/// @param source  as in FinitePoints
geometry::Indices ToSource(const geometry::Indices& source, const pcl::Indices& indices);
/// @throws std::invalid_argument with `what` ("option x must be > 0") unless `holds`.
inline void Demand(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

}  // namespace rangegrasp::pcl_bridge
