#include "views/merge.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "geometry/kd_tree.h"
#include "geometry/normals.h"

namespace rangegrasp::views {
namespace {

using geometry::Points;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// With fewer points there is nothing to lay one view onto another with.
constexpr std::size_t kMinPoints = 100;
/// Surfaces that meet at more than this are not the same: cos 45 deg.
constexpr double kMinCosine = 0.7;
/// Of pairs that fit perfectly, as in a test without noise: 10 um.
constexpr double kMinVariance = 1e-10;

void AddPoints(const geometry::View& view, const Eigen::AlignedBox3d& region_C, Points& points) {
  for (const Eigen::Vector3d& p_C : view.image.points_C) {
    if (p_C.allFinite() && region_C.contains(p_C)) points.push_back(p_C);
  }
}

Points EverySoMany(const Points& points, std::size_t max_points) {
  const std::size_t step = std::max<std::size_t>(1, (points.size() + max_points - 1) / max_points);
  Points some;
  for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
  return some;
}

/// What the pairs tell of the motion that is left: A x = b, without sigma.
struct Pairs {
  Matrix6 A = Matrix6::Zero();
  Vector6 b = Vector6::Zero();
  double squares = 0.0;  ///< of the distances across the surface [m^2]
  std::size_t count = 0;

  double Rms() const { return std::sqrt(squares / static_cast<double>(count)); }
};

/// Points that were measured before.
class Earlier {
 public:
  Earlier(Points points, const Eigen::Vector3d& eye, double normal_radius_m)
      : points_(std::move(points)),
        tree_(points_),
        normals_(geometry::EstimateNormals(points_, tree_, normal_radius_m, eye)) {}
  Earlier(const Earlier&) = delete;
  Earlier& operator=(const Earlier&) = delete;

  /// @param normals  of the points, as they were before the motion: it turns them by little
  Pairs PairsWith(const Points& points, const Points& normals, const core::Pose& X,
                  const Eigen::Vector3d& about, double max_pair_m) const {
    Pairs pairs;
    std::vector<geometry::KdTree::Neighbor> nearest;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d p = X * points[i];
      tree_.Nearest(p, 1, nearest);
      const auto& found = nearest.front();
      if (found.squared_distance > max_pair_m * max_pair_m) continue;
      const Eigen::Vector3d& n = normals_[found.index];
      if (std::abs(n.dot(normals[i])) < kMinCosine) continue;
      const double across_m = n.dot(p - points_[found.index]);
      Vector6 J;
      J << n, (p - about).cross(n);
      pairs.A += J * J.transpose();
      pairs.b -= J * across_m;
      pairs.squares += across_m * across_m;
      ++pairs.count;
    }
    return pairs;
  }

 private:
  Points points_;
  geometry::KdTree tree_;
  Points normals_;
};

/// A small motion about a place by its shift and turn.
core::Pose PoseOf(const Vector6& twist, const Eigen::Vector3d& about) {
  const Eigen::Vector3d turn = twist.tail<3>();
  core::Pose X = core::Pose::Identity();
  X.linear() = Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()).toRotationMatrix();
  X.translation() = about + twist.head<3>() - X.linear() * about;
  return X;
}

/// The inverse of the error's covariance.
Vector6 PriorOf(const PoseError& error) {
  Vector6 prior;
  prior.head<3>().setConstant(3.0 / (error.shift_m * error.shift_m));
  prior.tail<3>().setConstant(3.0 / (error.turn_rad * error.turn_rad));
  return prior;
}

}  // namespace

geometry::View Moved(geometry::View view, const core::Pose& X_by) {
  for (Eigen::Vector3d& p_C : view.image.points_C) p_C = X_by * p_C;
  for (Eigen::Vector3d& origin_C : view.image.origins_C) origin_C = X_by * origin_C;
  view.X_CV = X_by * view.X_CV;
  return view;
}

Refinement Refine(const geometry::Observation& earlier, const geometry::View& view,
                  const Eigen::AlignedBox3d& region_C, const RefineOptions& options) {
  Points target, source;
  for (const geometry::View& one : earlier.views) AddPoints(one, region_C, target);
  AddPoints(view, region_C, source);
  Refinement result;
  if (target.size() < kMinPoints || source.size() < kMinPoints) return result;
  source = EverySoMany(source, options.max_points);
  const Eigen::Vector3d about = view.X_CV.translation();
  const Earlier before(EverySoMany(target, 3 * options.max_points), about, options.normal_radius_m);
  const Points normals =
      geometry::EstimateNormals(source, geometry::KdTree(source), options.normal_radius_m, about);
  const Vector6 prior = PriorOf(options.error);
  Vector6 twist = Vector6::Zero();
  Pairs pairs;
  for (int i = 0; i < options.max_iterations; ++i) {
    pairs = before.PairsWith(source, normals, PoseOf(twist, about), about, options.max_pair_m);
    if (pairs.count < kMinPoints) return result;
    const double variance =
        options.points_a_fact * std::max(pairs.Rms() * pairs.Rms(), kMinVariance);
    const Matrix6 A = pairs.A / variance + Matrix6(prior.asDiagonal());
    const Vector6 step = A.ldlt().solve(pairs.b / variance - prior.cwiseProduct(twist));
    twist += step;
    if (step.head<3>().norm() < options.min_step_m && step.tail<3>().norm() < options.min_step_m) {
      break;
    }
  }
  result.pairs = pairs.count;
  result.rms_m = pairs.Rms();
  result.deviations = std::sqrt(twist.cwiseAbs2().dot(prior));
  result.refined = result.deviations <= options.max_deviations;
  if (result.refined) result.X_by = PoseOf(twist, about);
  return result;
}

}  // namespace rangegrasp::views
