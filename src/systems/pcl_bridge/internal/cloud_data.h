#pragma once

#include <pcl/PointIndices.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <stdexcept>

#include "pcl_bridge/cloud.h"

namespace rangegrasp::pcl_bridge {

using PclCloud = pcl::PointCloud<pcl::PointXYZ>;

struct Cloud::Data {
  PclCloud::Ptr finite{new PclCloud};  ///< p - origin of the finite points; never written to again
  geometry::Indices source;            ///< their positions in the points given, ascending
  std::size_t size = 0;                ///< of the points given
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
};

/// Converts the library's indices, which count finite points, to positions in the points given;
/// ascending.
geometry::Indices ToSource(const Cloud& cloud, const pcl::Indices& indices);
/// @throws std::invalid_argument with `what` ("option x must be > 0") unless `holds`.
inline void Demand(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

}  // namespace rangegrasp::pcl_bridge
