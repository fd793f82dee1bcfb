#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <vector>

#include "robot/mjcf/hand_closing.h"

namespace rangegrasp::mjcf {

/// The force [N or Nm] of each drive with which the thumb's last segments press with 1 N against
/// those of the fingers, in all, along the unit vector x_W (from the fingers to the thumb): the
/// equilibrium of the hand's joints,
///   R^T tau + A^T lambda = J^T f,
/// with the drives' moments R, the equalities' Jacobian A and their forces lambda, and the
/// Jacobian J of the segments' middles, which press with f; the least one where several do.
/// One drive alone needs no equilibrium: tau = -d(gap)/d(length), by virtual work.
/// @param data  after mj_forward or mj_step
std::vector<double> GripForces(const mjModel* model, const mjData* data,
                               const std::vector<HandMotor>& motors, const HandClosing& closing,
                               double share, const Eigen::Vector3d& x_W);

}  // namespace rangegrasp::mjcf
