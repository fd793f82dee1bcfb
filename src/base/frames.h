#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace rangegrasp::base {

class Rng;

/// Definition of the coordinate frames and the notation.
///
/// X_AB is the pose of frame B in A: p_A = X_AB * p_B. R_AB is its rotation. Internal units are SI.
///   W  world: origin on the table top at the middle of the workspace, z up, x from the arm
///      to the scanner
///   C  a point cloud; in a trial it equals W (the calibration is applied when the scan is made)
///   S  a sensor or camera: x right, y down, z forward along the optical axis
///   H  the hand's root body, as defined in its MJCF
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

/// The smallest rotation that takes one direction to another.
Eigen::Quaterniond TurnOnto(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// The axis and angle of a rotation matrix.
Eigen::AngleAxisd TurnOf(const Eigen::Matrix3d& R);

/// The pose of a rotation vector (its length is the angle [rad]) and a translation.
Pose SmallMotion(const Eigen::Vector3d& turn, const Eigen::Vector3d& shift);

/// Joint positions sampled at a constant period; between samples they are interpolated linearly.
struct JointTrajectory {
  double period_s = 0.01;                  ///< > 0
  std::vector<Eigen::VectorXd> positions;  ///< [rad], one vector of the arm's joints per sample

  double Duration() const {
    return positions.size() < 2 ? 0.0 : period_s * static_cast<double>(positions.size() - 1);
  }
};

/// Draws a pose error: translation and rotation with these root mean squares [m], [rad]. Six draws.
Pose DrawRigidError(double sigma_m, double sigma_rad, Rng& rng);

}  // namespace rangegrasp::base

// Nearly every source file uses these functions and would compile 3 s longer without this. Doxygen
// does not understand the syntax.
/// @cond
extern template Eigen::Isometry3d Eigen::Isometry3d::inverse(Eigen::TransformTraits) const;
extern template Eigen::Matrix3d Eigen::AngleAxisd::toRotationMatrix() const;
/// @endcond
