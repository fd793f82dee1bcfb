#pragma once

#include <Eigen/Core>

namespace rangegrasp::parts {

/// Eq. 2.33: the sum over i < j of (d_ij(X) - delta_ij)^2.
double Stress(const Eigen::MatrixXd& distances, const Eigen::MatrixX3d& positions);

/// Eq. 2.36-2.37 with all weights equal: U^+ B(X) X = B(X) X / N (the rows of B add up to zero, so
/// that the pseudoinverse's centring does nothing). Returns the stress of `positions`, found on the
/// way. O(N^2).
double GuttmanTransform(const Eigen::MatrixXd& distances, const Eigen::MatrixX3d& positions,
                        Eigen::MatrixX3d& next);

/// Classical scaling (Torgerson 1952): the three leading eigenvectors of the doubly centred squared
/// distances, each times the root of its eigenvalue (0 where that is negative); the largest entry
/// of each is positive.
Eigen::MatrixX3d ClassicalScaling(const Eigen::MatrixXd& distances);

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
