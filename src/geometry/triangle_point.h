#pragma once

#include <Eigen/Core>

namespace rangegrasp::geometry {

/// p + u (q - p) + v (r - p), with u and v of the unit square folded into the triangle: uniform
/// over the triangle where they are uniform over the square.
inline Eigen::Vector3d TrianglePoint(const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                                     const Eigen::Vector3d& r, double u, double v) {
  if (u + v > 1.0) {
    u = 1.0 - u;
    v = 1.0 - v;
  }
  return p + u * (q - p) + v * (r - p);
}

}  // namespace rangegrasp::geometry
