#pragma once

#include <Eigen/Core>
#include <optional>

namespace rangegrasp::base {

/// Eigen's decompositions that the core uses, compiled once: each takes 5 to 30 s of every source
/// that instantiates it. Results are Eigen's to the last bit.

/// Eigenvalues in rising order; column i of the vectors has length 1 and belongs to value i.
template <int N>
struct EigenPairs {
  Eigen::Matrix<double, N, 1> values;
  Eigen::Matrix<double, N, N> vectors;
};

/// Of a symmetric matrix (its lower triangle is read), by QR iterations. N is 2 or 3.
template <int N>
EigenPairs<N> SymmetricEigen(const Eigen::Matrix<double, N, N>& A);

/// The same in closed form: faster, and less accurate where values differ by orders of magnitude.
EigenPairs<3> SymmetricEigenDirect(const Eigen::Matrix3d& A);

/// A^-1 b of a symmetric matrix, by LDL^T with pivots. Not finite where A is singular, or any
/// solution: callers check. N is 2, 3, 4 or Eigen::Dynamic with M = 1, or N = M = 3.
template <int N, int M>
Eigen::Matrix<double, N, M> SolveLdlt(const Eigen::Matrix<double, N, N>& A,
                                      const Eigen::Matrix<double, N, M>& b);

/// A^-1 b of a positive definite matrix, by LL^T.
Eigen::Matrix<double, 6, 1> SolveLlt(const Eigen::Matrix<double, 6, 6>& A,
                                     const Eigen::Matrix<double, 6, 1>& b);

/// The shortest of the vectors that minimise |A x - b|.
Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// The vector that minimises |A x - b|; nullopt if the columns of A depend on each other.
std::optional<Eigen::VectorXd> UniqueLeastSquares(const Eigen::MatrixXd& A,
                                                  const Eigen::VectorXd& b);

}  // namespace rangegrasp::base
