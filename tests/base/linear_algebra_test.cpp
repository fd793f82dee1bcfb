#include "base/linear_algebra.h"

#include <gtest/gtest.h>

#include "base/rng.h"

namespace rangegrasp::base {
namespace {

template <int N, int M>
Eigen::Matrix<double, N, M> Random(Rng& rng, int rows = N, int columns = M) {
  Eigen::Matrix<double, N, M> matrix(rows, columns);
  for (double& entry : matrix.reshaped()) entry = rng.Normal();
  return matrix;
}

template <int N>
void ExpectPairs(const Eigen::Matrix<double, N, N>& A, const EigenPairs<N>& pairs) {
  const Eigen::Matrix<double, N, N> again =
      pairs.vectors * pairs.values.asDiagonal() * pairs.vectors.transpose();
  EXPECT_LT((again - A).norm(), 1e-8 * A.norm());
  EXPECT_TRUE(pairs.vectors.isUnitary(1e-8));
  for (int i = 1; i < N; ++i) EXPECT_LE(pairs.values[i - 1], pairs.values[i]);
}

TEST(LinearAlgebra, EigenPairsMakeUpTheMatrixInRisingOrder) {
  Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const auto two = Random<2, 2>(rng);
    const auto three = Random<3, 3>(rng);
    const Eigen::Matrix2d A2 = two + two.transpose();
    const Eigen::Matrix3d A3 = three + three.transpose();
    ExpectPairs<2>(A2, SymmetricEigen(A2));
    ExpectPairs<3>(A3, SymmetricEigen(A3));
    ExpectPairs<3>(A3, SymmetricEigenDirect(A3));
  }
}

template <int N>
void ExpectSolved(Rng& rng, int size = N) {
  const auto root = Random<N, N>(rng, size, size);
  const Eigen::Matrix<double, N, N> A =
      root * root.transpose() + Eigen::Matrix<double, N, N>::Identity(size, size);
  const auto b = Random<N, 1>(rng, size, 1);
  EXPECT_LT((A * SolveLdlt<N, 1>(A, b) - b).norm(), 1e-10 * b.norm());
}

TEST(LinearAlgebra, SolutionsOfSymmetricSystemsFulfilThem) {
  Rng rng(2);
  for (int i = 0; i < 100; ++i) {
    ExpectSolved<2>(rng);
    ExpectSolved<3>(rng);
    ExpectSolved<4>(rng);
    ExpectSolved<Eigen::Dynamic>(rng, 9);
    const auto root = Random<6, 6>(rng);
    const Eigen::Matrix<double, 6, 6> A =
        root * root.transpose() + Eigen::Matrix<double, 6, 6>::Identity();
    const auto b = Random<6, 1>(rng);
    EXPECT_LT((A * SolveLlt(A, b) - b).norm(), 1e-10 * b.norm());
    const Eigen::Matrix3d inverse =
        SolveLdlt<3, 3>(A.topLeftCorner<3, 3>(), Eigen::Matrix3d::Identity());
    EXPECT_TRUE((inverse * A.topLeftCorner<3, 3>()).isIdentity(1e-10));
  }
}

TEST(LinearAlgebra, OfAllLeastSquaresTheShortestIsTaken) {
  Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    // Rank 3: adding a vector orthogonal to all rows gives another solution, but a longer one.
    const Eigen::MatrixXd rows = Random<3, 5>(rng);
    const Eigen::MatrixXd A = Random<7, 3>(rng) * rows;
    const Eigen::VectorXd b = Random<7, 1>(rng);
    const Eigen::VectorXd x = LeastSquares(A, b);
    EXPECT_LT((A.transpose() * (A * x - b)).norm(), 1e-9 * b.norm() * A.norm());
    const Eigen::VectorXd in_rows = rows.transpose() * LeastSquares(rows.transpose(), x);
    EXPECT_LT((in_rows - x).norm(), 1e-9 * x.norm());
    EXPECT_FALSE(UniqueLeastSquares(A, b));
  }
}

TEST(LinearAlgebra, WhereColumnsAreIndependentTheLeastSquaresAreUnique) {
  Rng rng(4);
  for (int i = 0; i < 100; ++i) {
    const Eigen::MatrixXd A = Random<9, 4>(rng);
    const Eigen::VectorXd expected = Random<4, 1>(rng);
    const auto x = UniqueLeastSquares(A, A * expected);
    ASSERT_TRUE(x);
    EXPECT_LT((*x - expected).norm(), 1e-9 * expected.norm());
  }
}

}  // namespace
}  // namespace rangegrasp::base
