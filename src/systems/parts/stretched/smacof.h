#pragma once

#include <Eigen/Core>
#include <vector>

namespace rangegrasp::parts {

/// Eq. 2.33: the sum over i < j of (d_ij(X) - delta_ij)^2.
double Stress(const Eigen::MatrixXd& distances, const Eigen::MatrixX3d& positions);

/// Eq. 2.36-2.37 with all weights equal: U^+ B(X) X = B(X) X / N (the rows of B add up to zero, so
/// that the pseudoinverse's centring does nothing). Returns the stress of `positions`, found on the
/// way. O(N^2).
double GuttmanTransform(const Eigen::MatrixXd& distances, const Eigen::MatrixX3d& positions,
                        Eigen::MatrixX3d& next);

/// Classical scaling (Torgerson 1952): the three leading eigenvectors of the doubly centerd squared
/// distances, each times the root of its eigenvalue (0 where that is negative); the largest entry
/// of each is positive.
Eigen::MatrixX3d ClassicalScaling(const Eigen::MatrixXd& distances);

struct SmacofOptions {
  int iterations = 60;      ///< >= 1, at most
  double tolerance = 1e-4;  ///< stops when stress falls by less, relatively
};
struct Embedding {
  Eigen::MatrixX3d positions;
  std::vector<double> stress;  ///< after each iteration: never rises (eq. 6.9, 2.33)
};
/// Eq. 2.33-2.37 (SMACOF) from a start; by default classical scaling of the distances.
Embedding Smacof(const Eigen::MatrixXd& distances, const SmacofOptions& options,
                 const Eigen::MatrixX3d* start = nullptr);

}  // namespace rangegrasp::parts
