#include "base/frames.h"

#include <cmath>

#include "base/rng.h"

template Eigen::Isometry3d Eigen::Isometry3d::inverse(Eigen::TransformTraits) const;
template Eigen::Matrix3d Eigen::AngleAxisd::toRotationMatrix() const;

namespace rangegrasp::base {

Eigen::Quaterniond TurnOnto(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

Eigen::AngleAxisd TurnOf(const Eigen::Matrix3d& R) { return Eigen::AngleAxisd(R); }

Pose SmallMotion(const Eigen::Vector3d& turn, const Eigen::Vector3d& shift) {
  const Eigen::AngleAxisd rotation(turn.norm(), turn.stableNormalized());
  return MakePose(rotation.toRotationMatrix(), shift);
}

Pose DrawRigidError(double sigma_m, double sigma_rad, Rng& rng) {
  const auto vector = [&rng](double sigma) {
    const double x = rng.Normal();
    const double y = rng.Normal();
    const double z = rng.Normal();
    return Eigen::Vector3d(Eigen::Vector3d(x, y, z) * sigma / std::sqrt(3.0));
  };
  const Eigen::Vector3d shift = vector(sigma_m);
  return SmallMotion(vector(sigma_rad), shift);
}

}  // namespace rangegrasp::base
