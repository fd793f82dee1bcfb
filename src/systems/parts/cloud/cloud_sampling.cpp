#include "parts/cloud/cloud_sampling.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/quantile.h"
#include "base/units.h"
#include "geometry/groups.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::KdTree;
using geometry::Points;
using SampleNeighbors = std::vector<KdTree::Neighbor>;

/// Points looked at: their median is known to about 4 %.
constexpr std::size_t kSamples = 1000;
/// Where the search for the ball begins: it grows from there.
constexpr std::size_t kFirstNeighbors = 20;
/// The ball's radius in spacings: about 20 points, three for each parameter of a quadric.
constexpr double kBallSpacings = 2.5;
/// The same in noises: in a smaller ball the slab of points has no thickness to measure, and the
/// residual is a share of the radius. From 4 on it is less than a quarter of it.
constexpr double kBallNoises = 5.0;
/// Rounds in which the ball's radius settles.
constexpr int kSamplingRounds = 6;

/// Root mean square distance, along the normal, from the quadric through the points of a ball.
std::optional<double> QuadricResidual(const Points& points, const SampleNeighbors& near,
                                      double radius) {
  constexpr Eigen::Index kParameters = 6;
  const auto count = static_cast<Eigen::Index>(near.size());
  if (count < 2 * kParameters) return std::nullopt;
  Vector3d mean = Vector3d::Zero();
  for (const auto& n : near) mean += points[n.index] / static_cast<double>(count);
  Matrix3d spread = Matrix3d::Zero();
  for (const auto& n : near) {
    const Vector3d d = (points[n.index] - mean) / radius;
    spread += d * d.transpose();
  }
  const Matrix3d axes = Eigen::SelfAdjointEigenSolver<Matrix3d>(spread).eigenvectors();
  Eigen::Matrix<double, Eigen::Dynamic, kParameters> terms(count, kParameters);
  Eigen::VectorXd heights(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector3d at =
        axes.transpose() * (points[near[static_cast<std::size_t>(i)].index] - mean) / radius;
    terms.row(i) << 1.0, at[1], at[2], at[1] * at[1], at[1] * at[2], at[2] * at[2];
    heights[i] = at[0];
  }
  const Eigen::VectorXd quadric =
      (terms.transpose() * terms).ldlt().solve(terms.transpose() * heights);
  return radius * std::sqrt((terms * quadric - heights).squaredNorm() /
                            static_cast<double>(count - kParameters));
}

double MedianOr(std::vector<double> values, double otherwise) {
  return values.empty() ? otherwise : base::UpperMedianOf(values);
}

}  // namespace

CloudSampling MeasureSampling(const Points& points, const KdTree& tree) {
  Points sample;
  const std::size_t step = std::max<std::size_t>(1, points.size() / kSamples);
  for (std::size_t i = 0; i < points.size(); i += step) sample.push_back(points[i]);
  SampleNeighbors near;
  std::vector<double> reach;
  for (const Vector3d& p : sample) {
    tree.Nearest(p, kFirstNeighbors, near);
    reach.push_back(std::sqrt(near.back().squared_distance));
  }
  double radius = base::UpperMedianOf(reach);
  CloudSampling sampling;
  for (int round = 0; round < kSamplingRounds && radius > 0.0; ++round) {
    std::vector<double> residuals, spacings;
    for (const Vector3d& p : sample) {
      tree.Within(p, radius, near);
      spacings.push_back(radius * std::sqrt(base::kPi / static_cast<double>(near.size())));
      if (const auto one = QuadricResidual(points, near, radius)) residuals.push_back(*one);
    }
    sampling = {base::UpperMedianOf(spacings), MedianOr(std::move(residuals), 0.0)};
    radius = std::max(kBallSpacings * sampling.spacing, kBallNoises * sampling.noise);
  }
  return sampling;
}

std::vector<bool> StrayPoints(const Points& points, const KdTree& tree,
                              const CloudSampling& sampling) {
  // On an even surface a ball of this radius holds about 50 points; a scan is a few times as dense
  // in one place as in another.
  constexpr double kReach = 4.0;
  constexpr std::size_t kFew = 8;
  const double radius = std::max(kReach * sampling.spacing, 2.0 * sampling.noise);
  std::vector<bool> stray(points.size());
  for (const geometry::Indices& group : geometry::GroupsWithin(points, tree, radius)) {
    for (const std::uint32_t i : group) stray[i] = group.size() <= kFew;
  }
  return stray;
}

}  // namespace rangegrasp::parts
