#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "base/units.h"
#include "geometry/random_points.h"

/// Points on known surfaces with noise along their normals.
namespace rangegrasp::pcl_bridge::samples {

using geometry::samples::RandomDirection;
using geometry::samples::RandomPoint;

inline const Eigen::Vector3d kOrigin = Eigen::Vector3d::Zero();

/// Two unit vectors that span the plane perpendicular to `normal`.
inline Eigen::Matrix<double, 3, 2> Across(const Eigen::Vector3d& normal) {
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = normal.unitOrthogonal();
  basis.col(1) = normal.cross(basis.col(0));
  return basis;
}

/// n points on a square around `center` with sides of 2 `half`.
inline geometry::Points OnSquare(const Eigen::Vector3d& center, const Eigen::Vector3d& normal,
                                 double half, double sigma, std::size_t n, base::Rng& rng) {
  const auto basis = Across(normal);
  geometry::Points points;
  for (std::size_t i = 0; i < n; ++i) {
    const double u = rng.Uniform(-half, half);
    const double v = rng.Uniform(-half, half);
    points.push_back(center + basis * Eigen::Vector2d(u, v) + sigma * rng.Normal() * normal);
  }
  return points;
}

struct Tube {
  Eigen::Vector3d center;
  Eigen::Vector3d axis;
  double radius_m = 0.0;
  double half_length_m = 0.0;
};

inline geometry::Points OnTube(const Tube& tube, double sigma, std::size_t n, base::Rng& rng) {
  const auto basis = Across(tube.axis);
  geometry::Points points;
  for (std::size_t i = 0; i < n; ++i) {
    const double turn = rng.Uniform(0.0, 2.0 * base::kPi);
    const double along = rng.Uniform(-tube.half_length_m, tube.half_length_m);
    const double radius = tube.radius_m + sigma * rng.Normal();
    points.push_back(tube.center + along * tube.axis +
                     radius * (basis * Eigen::Vector2d(std::cos(turn), std::sin(turn))));
  }
  return points;
}

}  // namespace rangegrasp::pcl_bridge::samples
