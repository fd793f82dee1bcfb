#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "base/frames.h"
#include "base/rng.h"

namespace rangegrasp::base {

/// An error of a pose: a shift and a turn about any axis, root mean square [m], [rad]. Six draws.
inline Pose DrawRigidError(double sigma_m, double sigma_rad, Rng& rng) {
  const auto vector = [&rng](double sigma) {
    const double x = rng.Normal();
    const double y = rng.Normal();
    const double z = rng.Normal();
    return Eigen::Vector3d(Eigen::Vector3d(x, y, z) * sigma / std::sqrt(3.0));
  };
  const Eigen::Vector3d shift = vector(sigma_m);
  const Eigen::Vector3d turn = vector(sigma_rad);
  const Eigen::AngleAxisd rotation(turn.norm(), turn.stableNormalized());
  return MakePose(rotation.toRotationMatrix(), shift);
}

}  // namespace rangegrasp::base
