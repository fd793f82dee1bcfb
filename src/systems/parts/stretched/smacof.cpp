#include "parts/stretched/smacof.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace rangegrasp::parts {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixX3d;
using Eigen::MatrixXd;

/// Up to so many points all eigenvectors are found, which costs the cube of their number; above,
/// only the leading ones.
constexpr Index kMaxDense = 200;
/// Columns of the subspace in which three eigenvectors are looked for, and steps. An eigenvalue's
/// error shrinks in a step by its ratio to the first one outside of the subspace: more columns or
/// steps cost time, fewer leave the start of SMACOF rougher.
constexpr Index kSubspace = 12;
constexpr int kSubspaceSteps = 40;

/// -1/2 J D^2 J with J = I - 1 1^T / N.
MatrixXd DoublyCentered(const MatrixXd& distances) {
  MatrixXd b = -0.5 * distances.array().square();
  const Eigen::VectorXd row = b.rowwise().mean();
  const Eigen::RowVectorXd column = b.colwise().mean();
  const double all = row.mean();
  b.colwise() -= row;
  b.rowwise() -= column;
  b.array() += all;
  return b;
}

/// The leading three of eigenvalues (ascending) with their vectors as coordinates.
MatrixX3d Coordinates(const Eigen::VectorXd& values, const MatrixXd& vectors) {
  MatrixX3d x = MatrixX3d::Zero(vectors.rows(), 3);
  for (Index k = 0; k < std::min<Index>(3, values.size()); ++k) {
    const Index from = values.size() - 1 - k;
    Eigen::VectorXd v = vectors.col(from) * std::sqrt(std::max(0.0, values[from]));
    Index largest = 0;
    v.cwiseAbs().maxCoeff(&largest);
    x.col(k) = v[largest] < 0.0 ? Eigen::VectorXd(-v) : v;
  }
  return x;
}

/// Orthogonal iteration from columns of b itself, so that nothing is random.
MatrixX3d LeadingCoordinates(const MatrixXd& b) {
  MatrixXd q = b.leftCols(kSubspace);
  for (int step = 0; step < kSubspaceSteps; ++step) {
    const Eigen::HouseholderQR<MatrixXd> qr(q);
    q.noalias() = b * (qr.householderQ() * MatrixXd::Identity(b.rows(), kSubspace));
  }
  const Eigen::HouseholderQR<MatrixXd> qr(q);
  q = qr.householderQ() * MatrixXd::Identity(b.rows(), kSubspace);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> ritz(q.transpose() * b * q);
  return Coordinates(ritz.eigenvalues(), q * ritz.eigenvectors());
}

void CheckDistances(const MatrixXd& distances) {
  if (distances.rows() < 1 || distances.rows() != distances.cols() || !distances.allFinite()) {
    throw std::invalid_argument("Smacof: distances must be a square of finite numbers");
  }
}

}  // namespace

double GuttmanTransform(const MatrixXd& distances, const MatrixX3d& positions, MatrixX3d& next) {
  const Index n = distances.rows();
  next.resize(n, 3);
  double stress = 0.0;
  ArrayXd dx(n), dy(n), dz(n), d(n), ratio(n);
  for (Index j = 0; j < n; ++j) {
    dx = positions(j, 0) - positions.col(0).array();
    dy = positions(j, 1) - positions.col(1).array();
    dz = positions(j, 2) - positions.col(2).array();
    d = (dx.square() + dy.square() + dz.square()).sqrt();
    const auto delta = distances.col(j).array();
    stress += (d - delta).square().head(j).sum();
    ratio = (d > 0.0).select(delta / d, 0.0);
    next(j, 0) = (ratio * dx).sum();
    next(j, 1) = (ratio * dy).sum();
    next(j, 2) = (ratio * dz).sum();
  }
  next /= static_cast<double>(n);
  return stress;
}

double Stress(const MatrixXd& distances, const MatrixX3d& positions) {
  MatrixX3d unused;
  return GuttmanTransform(distances, positions, unused);
}

MatrixX3d ClassicalScaling(const MatrixXd& distances) {
  CheckDistances(distances);
  const MatrixXd b = DoublyCentered(distances);
  if (b.rows() > kMaxDense) return LeadingCoordinates(b);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(b);
  return Coordinates(solver.eigenvalues(), solver.eigenvectors());
}

Embedding Smacof(const MatrixXd& distances, const SmacofOptions& options, const MatrixX3d* start) {
  CheckDistances(distances);
  if (options.iterations < 1) throw std::invalid_argument("Smacof: iterations must be >= 1");
  if (start && start->rows() != distances.rows()) {
    throw std::invalid_argument("Smacof: the start must have one row a point");
  }
  Embedding result;
  result.positions = start ? *start : ClassicalScaling(distances);
  MatrixX3d next, after;
  double before = GuttmanTransform(distances, result.positions, next);
  for (int i = 0; i < options.iterations; ++i) {
    const double stress = GuttmanTransform(distances, next, after);
    if (stress > before) break;  // by rounding only: there is nothing left to gain
    result.positions.swap(next);
    result.stress.push_back(stress);
    if (before - stress <= options.tolerance * before) break;
    next.swap(after);
    before = stress;
  }
  if (result.stress.empty()) result.stress.push_back(before);
  return result;
}

}  // namespace rangegrasp::parts
