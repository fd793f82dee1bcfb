#include "base/linear_algebra.h"

#include <Eigen/Dense>

namespace rangegrasp::base {

using Eigen::Matrix;

template <int N>
EigenPairs<N> SymmetricEigen(const Matrix<double, N, N>& A) {
  const Eigen::SelfAdjointEigenSolver<Matrix<double, N, N>> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}
template EigenPairs<2> SymmetricEigen(const Eigen::Matrix2d&);
template EigenPairs<3> SymmetricEigen(const Eigen::Matrix3d&);

EigenPairs<3> SymmetricEigenDirect(const Eigen::Matrix3d& A) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template <int N, int M>
Matrix<double, N, M> SolveLdlt(const Matrix<double, N, N>& A, const Matrix<double, N, M>& b) {
  return A.ldlt().solve(b);
}
template Eigen::Vector2d SolveLdlt(const Eigen::Matrix2d&, const Eigen::Vector2d&);
template Eigen::Vector3d SolveLdlt(const Eigen::Matrix3d&, const Eigen::Vector3d&);
template Eigen::Matrix3d SolveLdlt(const Eigen::Matrix3d&, const Eigen::Matrix3d&);
template Eigen::Vector4d SolveLdlt(const Eigen::Matrix4d&, const Eigen::Vector4d&);
template Eigen::VectorXd SolveLdlt(const Eigen::MatrixXd&, const Eigen::VectorXd&);

Matrix<double, 6, 1> SolveLlt(const Matrix<double, 6, 6>& A, const Matrix<double, 6, 1>& b) {
  return A.llt().solve(b);
}

using OrthogonalDecomposition = Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>;

Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  return OrthogonalDecomposition(A).solve(b);
}

std::optional<Eigen::VectorXd> UniqueLeastSquares(const Eigen::MatrixXd& A,
                                                  const Eigen::VectorXd& b) {
  const OrthogonalDecomposition decomposition(A);
  if (decomposition.rank() < A.cols()) return std::nullopt;
  return decomposition.solve(b);
}

}  // namespace rangegrasp::base
