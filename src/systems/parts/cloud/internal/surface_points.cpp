#include "parts/cloud/internal/surface_points.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "base/statistics.h"
#include "base/units.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::KdTree;
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
    const Vector3d at = axes.transpose() * (points[near[i].index] - mean) / radius;
    terms.row(i) << 1.0, at[1], at[2], at[1] * at[1], at[1] * at[2], at[2] * at[2];
    heights[i] = at[0];
  }
  const Eigen::VectorXd quadric =
      (terms.transpose() * terms).ldlt().solve(terms.transpose() * heights);
  return radius * std::sqrt((terms * quadric - heights).squaredNorm() /
                            static_cast<double>(count - kParameters));
}

// ---- smoothing ----

/// Slope to which the local plane is to be known [rad]: bends of cuts are some tenths.
constexpr double kSlope = 0.1;
/// The ball of the local plane, in noises, at least: it must reach through the slab of points.
constexpr double kSmoothBallNoises = 3.0;
/// The same in spacings: fewer than five neighbors make no plane.
constexpr double kSmoothBallSpacings = 1.5;
/// Below this ball, in spacings, the points are as exact as their planes would be.
constexpr double kExact = 1.2;
/// Side of the cubes that are averaged, in noises: a slab of points has few layers of them.
constexpr double kCubeNoises = 1.5;
/// A plane's weights fall as exp(-kBell r^2 / radius^2): a bell of 0.4 radii.
constexpr double kBell = 3.0;
/// Steps towards the plane: each leaves about a third of a point's distance from the surface, so
/// that one at three noises comes to a fiftieth of one.
constexpr int kSmoothSteps = 5;
/// Noise, of the cubes' side, from which their means are nearer to the surface than one of their
/// points. Below, a mean would join the sides of thin walls.
constexpr double kMeans = 0.5;

/// A thinned cloud; a point stands for so many.
struct Thinned {
  Points points;
  std::vector<double> weight;
};

/// Of each cube of a grid the mean of its points or, to pick one, that nearest to its middle.
Thinned ThinOut(const Points& points, double side, bool pick) {
  struct Cube {
    Vector3d sum = Vector3d::Zero();
    double count = 0.0;
    double distance = std::numeric_limits<double>::infinity();
    std::uint32_t nearest = 0;
  };
  std::map<std::array<int, 3>, Cube> cubes;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Vector3d at = points[i] / side;
    const Eigen::Vector3i corner = at.array().floor().cast<int>();
    Cube& cube = cubes[{corner.x(), corner.y(), corner.z()}];
    cube.sum += points[i];
    cube.count += 1.0;
    const double distance = (at - corner.cast<double>() - Vector3d::Constant(0.5)).squaredNorm();
    if (distance >= cube.distance) continue;
    cube.distance = distance;
    cube.nearest = i;
  }
  Thinned thinned;
  for (const auto& [corner, cube] : cubes) {
    thinned.points.push_back(pick ? points[cube.nearest] : Vector3d(cube.sum / cube.count));
    thinned.weight.push_back(cube.count);
  }
  return thinned;
}

/// p on the plane that is fitted to the points about it, step by step.
Vector3d OntoSurface(const Thinned& cloud, const std::vector<KdTree::Neighbor>& near,
                     const Vector3d& p, double radius) {
  Vector3d at = p;
  for (int step = 0; step < kSmoothSteps; ++step) {
    double sum = 0.0;
    Vector3d mean = Vector3d::Zero();
    Matrix3d square = Matrix3d::Zero();
    for (const auto& n : near) {
      const Vector3d d = cloud.points[n.index] - at;
      const double weight =
          cloud.weight[n.index] * std::exp(-kBell * d.squaredNorm() / (radius * radius));
      sum += weight;
      mean += weight * d;
      square += weight * d * d.transpose();
    }
    mean /= sum;
    Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
    solver.computeDirect(square / sum - mean * mean.transpose());
    const Vector3d normal = solver.eigenvectors().col(0);
    at += normal * normal.dot(mean);
  }
  return at;
}

/// Side of the cubes of which one point is kept.
double ThinnedSpacing(std::size_t points, const CloudSampling& sampling, int max_points) {
  return sampling.spacing * std::max(1.0, std::sqrt(static_cast<double>(points) / max_points));
}

/// About `max_points` points at most, nowhere denser than that asks for, with the noise taken out;
/// in the order of a grid.
Points SmoothSurface(const Points& points, const CloudSampling& sampling, int max_points) {
  const auto& [spacing, noise] = sampling;
  // A plane through points of a disc of radius r, one an area of spacing^2, has a slope of
  // 2 noise spacing / (sqrt(pi) r^2).
  const double needed = std::max(kSmoothBallNoises * noise,
                                 std::sqrt(2.0 * noise * spacing / std::sqrt(base::kPi) / kSlope));
  const bool exact = needed <= kExact * spacing;
  const double side =
      std::max(ThinnedSpacing(points.size(), sampling, max_points), kCubeNoises * noise);
  Thinned thinned = ThinOut(points, side, noise < kMeans * side);
  if (exact) return std::move(thinned.points);
  const double radius = std::max(needed, kSmoothBallSpacings * spacing);
  const KdTree tree(thinned.points);
  std::vector<KdTree::Neighbor> near;
  Points smooth;
  for (const Vector3d& p : thinned.points) {
    tree.Within(p, 2.0 * radius, near);
    smooth.push_back(OntoSurface(thinned, near, p, radius));
  }
  return smooth;
}

/// Some of the points, no two of them nearer than `distance` to each other, so that no other could
/// be added; the first come first.
Points SpreadOut(const Points& points, double distance) {
  const KdTree tree(points);
  std::vector<KdTree::Neighbor> near;
  std::vector<bool> is_near(points.size(), false);
  Points spread;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (is_near[i]) continue;
    spread.push_back(points[i]);
    tree.Within(points[i], distance, near);
    for (const auto& n : near) is_near[n.index] = true;
  }
  return spread;
}

/// Cells are of 1000 faces' areas; three times as many points as these have corners.
constexpr int kMaxPoints = 15'000;
/// How near points may stand, in spacings: nearer ones make slivers.
constexpr double kMinDistance = 0.7;
/// Noise, in spacings, below which the nearest points lie next to a point, not above it.
constexpr double kNoisy = 0.25;

Points WithoutStrays(const Points& points) {
  const KdTree tree(points);
  const std::vector<bool> stray = StrayPoints(points, tree, MeasureSampling(points, tree));
  Points kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!stray[i]) kept.push_back(points[i]);
  }
  return kept.empty() ? points : kept;
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
    sampling = {base::UpperMedianOf(spacings),
                residuals.empty() ? 0.0 : base::UpperMedianOf(residuals)};
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
  for (const Indices& group : geometry::GroupsWithin(points, tree, radius)) {
    for (const std::uint32_t i : group) stray[i] = group.size() <= kFew;
  }
  return stray;
}

bool IsNoisy(const CloudSampling& sampling) { return sampling.noise > kNoisy * sampling.spacing; }

SurfacePoints PointsOfSurface(const Points& points) {
  const Points kept = WithoutStrays(points);
  const CloudSampling sampling = MeasureSampling(kept, KdTree(kept));
  const double spacing = ThinnedSpacing(kept.size(), sampling, kMaxPoints);
  return {SpreadOut(SmoothSurface(kept, sampling, kMaxPoints), kMinDistance * spacing), spacing,
          sampling.noise};
}

}  // namespace rangegrasp::parts
