#pragma once

#include <Eigen/Geometry>

namespace rangegrasp::base {

/// Frames and notation, stated once.
///
/// X_AB is the pose of frame B in frame A: p_A = X_AB * p_B. R_AB is its rotation. SI units inside.
///   W  world: origin on the table top at the middle of the workspace, z up, x from the arm to the
///   scanner. C  the frame of a cloud; in a trial it is W (the calibration is applied when the scan
///   is made). S  a sensor or camera: x right, y down, z forward along the optical axis. H  the
///   hand's root body as its MJCF gives it. F  the arm's flange: the parent body that the hand is
///   attached to. G  a grasp: origin at the tool centre, z_G the approach direction, x_G the
///   closing direction from the finger
///      pads to the thumb pad, y_G = z_G x x_G.
/// Quaternions are written (w, x, y, z) in files, as in MuJoCo.
using Pose = Eigen::Isometry3d;

/// Builds a pose from a rotation and a translation [m].
inline Pose MakePose(const Eigen::Matrix3d& R_AB, const Eigen::Vector3d& p_AB) {
  Pose X_AB = Pose::Identity();
  X_AB.linear() = R_AB;
  X_AB.translation() = p_AB;
  return X_AB;
}

}  // namespace rangegrasp::base
