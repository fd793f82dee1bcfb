#pragma once

#include <Eigen/Core>
#include <optional>

namespace rangegrasp::base {

/// Eigen's decompositions that the core uses, compiled once: each adds 5 to 30 s to the compile
/// time of every source file that instantiates it. Results are bit-identical to Eigen's.

/// Eigenvalues in ascending order; column i of the vectors is the unit eigenvector of value i.
template <int N>
struct EigenPairs {
  Eigen::Matrix<double, N, 1> values;
  Eigen::Matrix<double, N, N> vectors;
};

/// For a symmetric matrix (only its lower triangle is read), by QR iterations. N is 2 or 3.
template <int N>
EigenPairs<N> SymmetricEigen(const Eigen::Matrix<double, N, N>& A);

/// The same in closed form: faster, but less accurate if values differ by orders of magnitude.
EigenPairs<3> SymmetricEigenDirect(const Eigen::Matrix3d& A);

/// A^-1 b of a symmetric matrix, by LDL^T with pivoting. If A is singular, the result is not finite
/// or any solution: callers must check. N is 2, 3, 4 or Eigen::Dynamic with M = 1, or N = M = 3.
template <int N, int M>
Eigen::Matrix<double, N, M> SolveLdlt(const Eigen::Matrix<double, N, N>& A,
                                      const Eigen::Matrix<double, N, M>& b);

/// A^-1 b of a positive definite matrix, by LL^T.
Eigen::Matrix<double, 6, 1> SolveLlt(const Eigen::Matrix<double, 6, 6>& A,
                                     const Eigen::Matrix<double, 6, 1>& b);

/// The shortest vector that minimises |A x - b|.
Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// The vector that minimises |A x - b|; nullopt if the columns of A are linearly dependent.
std::optional<Eigen::VectorXd> UniqueLeastSquares(const Eigen::MatrixXd& A,
                                                  const Eigen::VectorXd& b);

}  // namespace rangegrasp::base
