#include "base/linear_algebra.h"

#include <Eigen/Dense>

namespace rangegrasp::base {

using Eigen::Matrix;
template <int N, int M>
using Sized = Matrix<double, N, M>;

template <int N>
EigenPairs<N> SymmetricEigen(const Matrix<double, N, N>& A) {
  const Eigen::SelfAdjointEigenSolver<Matrix<double, N, N>> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}
template EigenPairs<2> SymmetricEigen(const Matrix<double, 2, 2>&);
template EigenPairs<3> SymmetricEigen(const Matrix<double, 3, 3>&);

EigenPairs<3> SymmetricEigenDirect(const Eigen::Matrix3d& A) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template <int N, int M>
Matrix<double, N, M> SolveLdlt(const Matrix<double, N, N>& A, const Matrix<double, N, M>& b) {
  return A.ldlt().solve(b);
}
// -1 is Eigen::Dynamic.
template Sized<2, 1> SolveLdlt(const Sized<2, 2>&, const Sized<2, 1>&);
template Sized<3, 1> SolveLdlt(const Sized<3, 3>&, const Sized<3, 1>&);
template Sized<3, 3> SolveLdlt(const Sized<3, 3>&, const Sized<3, 3>&);
template Sized<4, 1> SolveLdlt(const Sized<4, 4>&, const Sized<4, 1>&);
template Sized<-1, 1> SolveLdlt(const Sized<-1, -1>&, const Sized<-1, 1>&);

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
