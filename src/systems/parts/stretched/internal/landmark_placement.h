#pragma once

#include <Eigen/Core>

namespace rangegrasp::parts {

/// Places a point from its distances to embedded landmarks: the linear least squares of the squared
/// distances (de Silva and Tenenbaum 2004, landmark MDS), then `steps` times
/// x <- mean_i (X_i + delta_i (x - X_i) / |x - X_i|), the Guttman transform of one point with the
/// landmarks held, which lowers sum_i (|x - X_i| - delta_i)^2.
class LandmarkPlacement {
 public:
  explicit LandmarkPlacement(const Eigen::MatrixX3d& landmarks);
  Eigen::Vector3d Place(const Eigen::Ref<const Eigen::VectorXd>& distances, int steps) const;

 private:
  Eigen::MatrixX3d landmarks_;
  Eigen::MatrixX3d solve_;  ///< pseudoinverse, transposed
  Eigen::VectorXd squared_norms_;
  Eigen::Vector3d center_;
};

}  // namespace rangegrasp::parts
