#pragma once

#include <cmath>
#include <numbers>

#include "base/rng.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::parts::samples {

/// Uniform on the unit ball's surface (Archimedes: heights are uniform).
inline Eigen::Vector3d BallPoint(base::Rng& rng) {
  const double z = rng.Uniform(-1.0, 1.0);
  const double angle = rng.Uniform(0.0, 2.0 * std::numbers::pi);
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

/// p with normally distributed noise in each coordinate.
inline Eigen::Vector3d Noisy(const Eigen::Vector3d& p, double noise, base::Rng& rng) {
  Eigen::Vector3d off;
  for (double& x : off) x = noise * rng.Normal();
  return p + off;
}

}  // namespace rangegrasp::parts::samples
