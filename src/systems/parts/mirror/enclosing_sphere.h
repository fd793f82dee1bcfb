#pragma once

#include <Eigen/Core>

#include "geometry/point_cloud.h"

namespace rangegrasp::parts {

struct Sphere {
  Eigen::Vector3d center;
  double radius;
};
/// The exact smallest enclosing sphere (Gaertner 1999; CGAL). @throws std::invalid_argument without
/// points.
Sphere SmallestEnclosingSphere(geometry::PointSpan points);
/// The smallest sphere round a given center that holds the points (R of eq. 6.1).
Sphere SphereRound(const Eigen::Vector3d& center, geometry::PointSpan points);

}  // namespace rangegrasp::parts
