#include "parts/cloud/internal/smooth_surface.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "base/units.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::KdTree;
using geometry::Points;

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

}  // namespace

double ThinnedSpacing(std::size_t points, const CloudSampling& sampling, int max_points) {
  return sampling.spacing * std::max(1.0, std::sqrt(static_cast<double>(points) / max_points));
}

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

}  // namespace rangegrasp::parts
