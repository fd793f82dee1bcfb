#include "parts/stretched/internal/landmark_placement.h"

#include <Eigen/QR>

namespace rangegrasp::parts {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixX3d;
using Eigen::MatrixXd;

LandmarkPlacement::LandmarkPlacement(const MatrixX3d& landmarks)
    : landmarks_(landmarks), center_(landmarks.colwise().mean().transpose()) {
  const MatrixX3d centered = landmarks_.rowwise() - center_.transpose();
  // x^T X_i = (|X_i|^2 - delta_i^2 + const) / 2 for every i, all from the center.
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition(centered);
  solve_ = decomposition.pseudoInverse().transpose();
  squared_norms_ = centered.rowwise().squaredNorm();
}

Eigen::Vector3d LandmarkPlacement::Place(const Eigen::Ref<const Eigen::VectorXd>& distances,
                                         int steps) const {
  Eigen::Vector3d x =
      center_ + 0.5 * (solve_.transpose() *
                       (squared_norms_ - distances.cwiseAbs2()));  // columns of solve_ add up to 0
  const Index n = landmarks_.rows();
  ArrayXd dx(n), dy(n), dz(n), d(n), ratio(n);
  for (int step = 0; step < steps; ++step) {
    dx = x[0] - landmarks_.col(0).array();
    dy = x[1] - landmarks_.col(1).array();
    dz = x[2] - landmarks_.col(2).array();
    d = (dx.square() + dy.square() + dz.square()).sqrt();
    ratio = (d > 0.0).select(distances.array() / d, 0.0);
    x = center_ + Eigen::Vector3d((ratio * dx).mean(), (ratio * dy).mean(), (ratio * dz).mean());
  }
  return x;
}

}  // namespace rangegrasp::parts
