#include "robot/robot.h"

#include <Eigen/Geometry>

namespace rangegrasp::robot {
namespace {

/// Moves X_WP on to the link: X_WB at joint position angle.
base::Pose Advance(const base::Pose& X_WP, const Link& link, double angle) {
  base::Pose X_WB = X_WP * link.X_PB;
  if (link.joint < 0) return X_WB;
  const Eigen::Vector3d anchor_W = X_WB * link.anchor_B;
  X_WB.linear() = X_WB.linear() * Eigen::AngleAxisd(angle, link.axis_B).toRotationMatrix();
  X_WB.translation() = anchor_W - X_WB.linear() * link.anchor_B;
  return X_WB;
}

double JointAngle(const Link& link, const Eigen::VectorXd& q) {
  return link.joint < 0 ? 0.0 : q[link.joint];
}

}  // namespace

std::vector<base::Pose> Robot::LinkPoses(const Eigen::VectorXd& q) const {
  std::vector<base::Pose> poses_W;
  poses_W.reserve(links_.size());
  for (const Link& link : links_) {
    const base::Pose X_WP =
        link.parent < 0 ? base::Pose::Identity() : poses_W[static_cast<std::size_t>(link.parent)];
    poses_W.push_back(Advance(X_WP, link, JointAngle(link, q)));
  }
  return poses_W;
}

base::Pose Robot::HandPose(const Eigen::VectorXd& q) const {
  base::Pose X_WB = base::Pose::Identity();
  for (const Link& link : links_) X_WB = Advance(X_WB, link, JointAngle(link, q));
  return X_WB * X_FH;
}

base::Pose Robot::HandPoseAndJacobian(const Eigen::VectorXd& q, Eigen::MatrixXd& J_WH) const {
  J_WH.resize(6, dof());
  base::Pose X_WB = base::Pose::Identity();
  // The upper half holds the anchors until the hand's position is known.
  for (const Link& link : links_) {
    X_WB = Advance(X_WB, link, JointAngle(link, q));
    if (link.joint < 0) continue;
    J_WH.col(link.joint).head<3>() = X_WB * link.anchor_B;
    J_WH.col(link.joint).tail<3>() = X_WB.linear() * link.axis_B;
  }
  const base::Pose X_WH = X_WB * X_FH;
  for (Eigen::Index i = 0; i < J_WH.cols(); ++i) {
    const Eigen::Vector3d arm_W = X_WH.translation() - J_WH.col(i).head<3>();
    const Eigen::Vector3d axis_W = J_WH.col(i).tail<3>();
    J_WH.col(i).head<3>() = axis_W.cross(arm_W);
  }
  return X_WH;
}

Eigen::MatrixXd Robot::HandJacobian(const Eigen::VectorXd& q) const {
  Eigen::MatrixXd J_WH;
  HandPoseAndJacobian(q, J_WH);
  return J_WH;
}

}  // namespace rangegrasp::robot
