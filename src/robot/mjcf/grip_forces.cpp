#include "robot/mjcf/grip_forces.h"

#include <Eigen/QR>

namespace rangegrasp::mjcf {
namespace {

/// Column k: what one unit of force of the k-th drive, then of the k-th equality, does to the
/// hand's joints.
Eigen::MatrixXd Columns(const mjModel* model, const mjData* data,
                        const std::vector<HandMotor>& motors) {
  const auto drives = static_cast<Eigen::Index>(motors.size());
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(model->nv, drives + data->ne);
  for (Eigen::Index k = 0; k < drives; ++k) {
    const int out = model->actuator_outadr[motors[static_cast<std::size_t>(k)].actuator];
    for (int i = 0; i < data->moment_rownnz[out]; ++i) {
      const int at = data->moment_rowadr[out] + i;
      all(data->moment_colind[at], k) = data->actuator_moment[at];
    }
  }
  for (int row = 0; row < data->ne; ++row) {
    if (!mj_isSparse(model)) {
      for (int dof = 0; dof < model->nv; ++dof) {
        all(dof, drives + row) = data->efc_J[static_cast<std::ptrdiff_t>(row) * model->nv + dof];
      }
      continue;
    }
    for (int i = 0; i < data->efc_J_rownnz[row]; ++i) {
      const int at = data->efc_J_rowadr[row] + i;
      all(data->efc_J_colind[at], drives + row) = data->efc_J[at];
    }
  }
  return all;
}

/// What the joints have to give where the last segments press.
Eigen::VectorXd Wanted(const mjModel* model, const mjData* data, const Eigen::Vector3d& x_W) {
  const LastSegments tips = LastSegmentsOf(model);
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> J(3, model->nv);
  Eigen::VectorXd wanted = Eigen::VectorXd::Zero(model->nv);
  const auto press = [&](const std::vector<int>& geoms, const Eigen::Vector3d& direction_W) {
    for (const int geom : geoms) {
      mj_jacGeom(model, data, J.data(), nullptr, geom);
      wanted += J.transpose() * direction_W / static_cast<double>(geoms.size());
    }
  };
  press(tips.thumb, -x_W);
  press(tips.fingers, x_W);
  return wanted;
}

}  // namespace

std::vector<double> GripForces(const mjModel* model, const mjData* data,
                               const std::vector<HandMotor>& motors, const HandClosing& closing,
                               double share, const Eigen::Vector3d& x_W) {
  if (motors.size() == 1) return {closing.NarrowingAt(share) / motors.front().Travel()};
  const Eigen::MatrixXd all = Columns(model, data, motors);
  const Eigen::VectorXd wanted = Wanted(model, data, x_W);
  const auto joints = static_cast<Eigen::Index>(closing.joints.size());
  Eigen::MatrixXd of_hand(joints, all.cols());
  Eigen::VectorXd of_tips(joints);
  for (Eigen::Index i = 0; i < joints; ++i) {
    const int dof = model->jnt_dofadr[closing.joints[static_cast<std::size_t>(i)]];
    of_hand.row(i) = all.row(dof);
    of_tips[i] = wanted[dof];
  }
  const Eigen::VectorXd forces = of_hand.completeOrthogonalDecomposition().solve(of_tips).head(
      static_cast<Eigen::Index>(motors.size()));
  return {forces.data(), forces.data() + forces.size()};
}

}  // namespace rangegrasp::mjcf
