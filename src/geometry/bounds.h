#pragma once

#include <Eigen/Geometry>

#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// The box about points, along the axes of their frame; empty without a point.
inline Eigen::AlignedBox3d BoundsOf(PointSpan points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  return box;
}

}  // namespace rangegrasp::geometry
