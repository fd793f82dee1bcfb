#pragma once

#include <vector>

#include "base/rng.h"
#include "geometry/point_cloud.h"

/// Random clouds for tests.
namespace rangegrasp::geometry::samples {

inline Eigen::Vector3d RandomPoint(double half, base::Rng& rng) {
  const double x = rng.Uniform(-half, half);
  const double y = rng.Uniform(-half, half);
  const double z = rng.Uniform(-half, half);
  return {x, y, z};
}

/// Each component is normal with mean 0 and variance 1.
inline Eigen::Vector3d RandomVector(base::Rng& rng) {
  const double x = rng.Normal();
  const double y = rng.Normal();
  const double z = rng.Normal();
  return {x, y, z};
}

inline Eigen::Vector3d RandomDirection(base::Rng& rng) { return RandomVector(rng).normalized(); }

/// Uniform in the cube from 0 to 1.
inline Eigen::Vector3d RandomInUnitCube(base::Rng& rng) {
  const double x = rng.Uniform();
  const double y = rng.Uniform();
  const double z = rng.Uniform();
  return {x, y, z};
}

inline Points RandomPoints(std::size_t n, double half, base::Rng& rng) {
  Points points;
  for (std::size_t i = 0; i < n; ++i) points.push_back(RandomPoint(half, rng));
  return points;
}

/// 0 .. n - 1 in random order (Fisher-Yates).
inline Indices Permutation(std::size_t n, base::Rng& rng) {
  Indices order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = static_cast<std::uint32_t>(i);
  for (std::size_t i = n; i > 1; --i) std::swap(order[i - 1], order[rng.Index(i)]);
  return order;
}

}  // namespace rangegrasp::geometry::samples
