#include "recognition/views/merge.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "geometry/kd_tree.h"
#include "geometry/plane.h"

namespace rangegrasp::views {
namespace {

using geometry::Points;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// With fewer points, views cannot be aligned.
constexpr std::size_t kMinPoints = 100;
/// Pairs whose normals differ by more (18 deg) are on two surfaces, or an edge bends one normal.
constexpr double kMinCosine = 0.95;
/// Minimum sigma, for pairs that fit perfectly, as in a test without noise.
constexpr double kMinSigma_m = 1e-5;
/// Ratio of the median absolute value of a normal distribution to its standard deviation.
constexpr double kMedianOfNormal = 0.6745;

/// Measured points, and the viewpoint of each.
struct Seen {
  Points points;
  Points eyes;
};

void AddPoints(const geometry::View& view, const Eigen::AlignedBox3d& region_C, Seen& seen) {
  for (std::uint32_t i = 0; i < view.image.points_C.size(); ++i) {
    const Eigen::Vector3d& p_C = view.image.points_C[i];
    if (!p_C.allFinite() || !region_C.contains(p_C)) continue;
    seen.points.push_back(p_C);
    seen.eyes.push_back(view.image.OriginOf(i));
  }
}

Seen EverySoMany(const Seen& seen, std::size_t max_points) {
  const std::size_t n = seen.points.size();
  const std::size_t step = std::max<std::size_t>(1, (n + max_points - 1) / max_points);
  Seen some;
  for (std::size_t i = 0; i < n; i += step) {
    some.points.push_back(seen.points[i]);
    some.eyes.push_back(seen.eyes[i]);
  }
  return some;
}

/// Normals toward each point's viewpoint: those on the two sides of a thin wall are opposite.
Points NormalsOf(const Points& points, const Points& eyes, const geometry::KdTree& tree,
                 double radius_m) {
  geometry::Indices own(points.size());
  std::iota(own.begin(), own.end(), 0u);
  return geometry::EstimateNormals(points, tree, radius_m, eyes, own);
}

/// Normal equations of the remaining motion from the pairs: A x = b, without sigma.
struct Pairs {
  Matrix6 A = Matrix6::Zero();
  Vector6 b = Vector6::Zero();
  std::vector<double> across_m;  ///< the distances along the normal
};

/// The points of views that were aligned before, or of one that is to be.
struct Surface {
  Surface(Seen seen, double normal_radius_m)
      : points(std::move(seen.points)),
        tree(points),
        normals(NormalsOf(points, seen.eyes, tree, normal_radius_m)) {}
  Surface(const Surface&) = delete;  // the tree refers to the points
  Surface& operator=(const Surface&) = delete;

  Points points;
  geometry::KdTree tree;
  Points normals;
};

/// @param X  motion of the source; it turns the normals only slightly
Pairs PairsOf(const Surface& source, const base::Pose& X, const Surface& target,
              const Eigen::Vector3d& about, double sigma_m, const RefineOptions& options) {
  Pairs pairs;
  std::vector<geometry::KdTree::Neighbor> nearest;
  for (std::size_t i = 0; i < source.points.size(); ++i) {
    const Eigen::Vector3d p = X * source.points[i];
    target.tree.Nearest(p, 1, nearest);
    const auto& found = nearest.front();
    const Eigen::Vector3d& n = target.normals[found.index];
    if (n.dot(source.normals[i]) < kMinCosine) continue;
    const double across_m = n.dot(p - target.points[found.index]);
    const double squared_aside = found.squared_distance - across_m * across_m;
    if (std::abs(across_m) > options.max_across_m ||
        squared_aside > options.max_aside_m * options.max_aside_m) {
      continue;
    }
    // Cauchy weights: pairs further apart than two sigma are usually on different surfaces.
    const double weight = 1.0 / (1.0 + across_m * across_m / (4.0 * sigma_m * sigma_m));
    Vector6 J;
    J << n, (p - about).cross(n);
    pairs.A += weight * J * J.transpose();
    pairs.b -= weight * J * across_m;
    pairs.across_m.push_back(std::abs(across_m));
  }
  return pairs;
}

/// A small motion from its shift and turn about a point.
base::Pose PoseOf(const Vector6& twist, const Eigen::Vector3d& about) {
  base::Pose X = base::SmallMotion(twist.tail<3>(), Eigen::Vector3d::Zero());
  X.translation() = about + twist.head<3>() - X.linear() * about;
  return X;
}

}  // namespace

geometry::View Moved(geometry::View view, const base::Pose& X_by) {
  for (Eigen::Vector3d& p_C : view.image.points_C) p_C = X_by * p_C;
  for (Eigen::Vector3d& origin_C : view.image.origins_C) origin_C = X_by * origin_C;
  view.X_CV = X_by * view.X_CV;
  return view;
}

Refinement Refine(const geometry::Observation& earlier, const geometry::View& view,
                  const Eigen::AlignedBox3d& region_C, const RefineOptions& options) {
  Seen target, source;
  for (const geometry::View& one : earlier.views) AddPoints(one, region_C, target);
  AddPoints(view, region_C, source);
  Refinement result;
  if (target.points.size() < kMinPoints || source.points.size() < kMinPoints) return result;
  const Surface after(EverySoMany(source, options.max_points), options.normal_radius_m);
  const Surface before(EverySoMany(target, 3 * options.max_points), options.normal_radius_m);
  const Eigen::Vector3d about = view.X_CV.translation();
  Vector6 prior;  // diagonal of the inverse covariance of the error
  prior.head<3>().setConstant(3.0 / (options.shift_error_m * options.shift_error_m));
  prior.tail<3>().setConstant(3.0 / (options.turn_error_rad * options.turn_error_rad));
  Vector6 twist = Vector6::Zero();
  double sigma_m = options.shift_error_m;
  for (int i = 0; i < options.max_iterations; ++i) {
    Pairs pairs = PairsOf(after, PoseOf(twist, about), before, about, sigma_m, options);
    if (pairs.across_m.size() < kMinPoints) return result;
    result.pairs = pairs.across_m.size();
    sigma_m = std::max(base::MedianOf(std::move(pairs.across_m)) / kMedianOfNormal, kMinSigma_m);
    const double variance = options.points_a_fact * sigma_m * sigma_m;
    const Matrix6 A = pairs.A / variance + Matrix6(prior.asDiagonal());
    const Vector6 step = A.ldlt().solve(pairs.b / variance - prior.cwiseProduct(twist));
    twist += step;
    if (step.head<3>().norm() < options.min_step_m && step.tail<3>().norm() < options.min_step_m) {
      break;
    }
  }
  result.sigma_m = sigma_m;
  result.deviations = std::sqrt(twist.cwiseAbs2().dot(prior));
  result.refined = result.deviations <= options.max_deviations;
  if (result.refined) result.X_by = PoseOf(twist, about);
  return result;
}

}  // namespace rangegrasp::views
