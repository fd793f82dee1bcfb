#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "base/rng.h"

namespace rangegrasp::base {

/// Frames and notation, stated once.
///
/// X_AB is the pose of frame B in frame A: p_A = X_AB * p_B. R_AB is its rotation. SI units inside.
///   W  world: origin on the table top at the middle of the workspace, z up, x from the arm
///      to the scanner
///   C  of a cloud; in a trial it is W (the calibration is applied when the scan is made)
///   S  of a sensor or camera: x right, y down, z forward along the optical axis
///   H  of the hand's root body, as its MJCF gives it
///   F  the arm's flange: the parent body that the hand is attached to
///   G  a grasp: origin at the tool centre, z_G the approach direction, x_G the closing direction
///      from the finger pads to the thumb pad, y_G = z_G x x_G
/// Quaternions are written (w, x, y, z) in files, as in MuJoCo.
using Pose = Eigen::Isometry3d;

inline Pose MakePose(const Eigen::Matrix3d& R_AB, const Eigen::Vector3d& p_AB) {
  Pose X_AB = Pose::Identity();
  X_AB.linear() = R_AB;
  X_AB.translation() = p_AB;
  return X_AB;
}

/// A turn about an axis, by its length [rad], and a shift.
inline Pose SmallMotion(const Eigen::Vector3d& turn, const Eigen::Vector3d& shift) {
  const Eigen::AngleAxisd rotation(turn.norm(), turn.stableNormalized());
  return MakePose(rotation.toRotationMatrix(), shift);
}

/// Joint positions sampled at a constant period; between samples they are interpolated linearly.
struct JointTrajectory {
  double period_s = 0.01;                  ///< > 0
  std::vector<Eigen::VectorXd> positions;  ///< [rad], one vector of the arm's joints a sample

  double Duration() const {
    return positions.size() < 2 ? 0.0 : period_s * static_cast<double>(positions.size() - 1);
  }
};

/// An error of a pose: a shift and a turn about any axis, root mean square [m], [rad]. Six draws.
inline Pose DrawRigidError(double sigma_m, double sigma_rad, Rng& rng) {
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
