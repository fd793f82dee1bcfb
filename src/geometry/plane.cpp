#include "geometry/plane.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "base/count_to_beat.h"

namespace rangegrasp::geometry {
namespace {

/// Below this sine of the angle at a corner three points count as collinear: rounding (1e-16 of
/// coordinates up to 1e3 times the triangle's size) can make no larger one of an exact line.
constexpr double kCollinear = 1e-9;
/// The same for the ratio of the two larger eigenvalues, which are squares and carry rounding.
constexpr double kCollinearSquared = 1e-14;
/// Points whose thickness is below this share of their extent are in one plane: a nanometre on a
/// metre, far below any sensor's noise and far above rounding.
constexpr double kFlat = 1e-9;

Eigen::Matrix3d Scatter(PointSpan points, const Eigen::Vector3d& mean) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d d = p - mean;
    scatter.noalias() += d * d.transpose();
  }
  return scatter;
}

Indices Inliers(PointSpan points, const Plane& plane, double distance_m) {
  Indices inliers;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::abs(plane.Distance(points[i])) <= distance_m) {
      inliers.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return inliers;
}

/// Three different positions below n >= 3.
std::array<std::size_t, 3> DrawThree(std::size_t n, base::Rng& rng) {
  const std::size_t a = rng.Index(n);
  std::size_t b = rng.Index(n - 1);
  if (b >= a) ++b;
  std::size_t c = rng.Index(n - 2);
  if (c >= std::min(a, b)) ++c;
  if (c >= std::max(a, b)) ++c;
  return {a, b, c};
}

}  // namespace

std::optional<Plane> PlaneThrough(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                  const Eigen::Vector3d& c) {
  const Eigen::Vector3d u = b - a;
  const Eigen::Vector3d v = c - a;
  const Eigen::Vector3d normal = u.cross(v);
  const double length = normal.norm();
  if (!(length > kCollinear * u.norm() * v.norm())) return std::nullopt;
  Plane plane;
  plane.normal = normal / length;
  plane.offset_m = -plane.normal.dot(a);
  return plane;
}

std::optional<Plane> FitPlane(PointSpan points) {
  if (points.size() < 3) return std::nullopt;
  const Eigen::Vector3d mean = Centroid(points);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(Scatter(points, mean));
  const Eigen::Vector3d values = solver.eigenvalues();
  // Eigenvalues are squared lengths: points are collinear if their spread across is nothing.
  if (!(values[1] > kCollinearSquared * values[2]) || !(values[2] > 0.0)) return std::nullopt;
  Plane plane;
  plane.normal = solver.eigenvectors().col(0).normalized();
  plane.offset_m = -plane.normal.dot(mean);
  return plane;
}

bool IsFlat(PointSpan points) {
  const auto plane = FitPlane(points);
  if (!plane) return true;
  Eigen::Vector3d low = points.front();
  Eigen::Vector3d high = low;
  double thickness = 0.0;
  for (const Eigen::Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
    thickness = std::max(thickness, std::abs(plane->Distance(p)));
  }
  return thickness <= kFlat * (high - low).norm();
}

std::optional<PlaneFit> FitPlaneRansac(PointSpan points, const PlaneRansacOptions& options,
                                       base::Rng& rng) {
  if (options.draws < 1) throw std::invalid_argument("FitPlaneRansac: draws must be >= 1");
  if (!(options.inlier_distance_m > 0.0)) {
    throw std::invalid_argument("FitPlaneRansac: inlier_distance_m must be > 0");
  }
  if (points.size() < 3) return std::nullopt;
  std::optional<Plane> best;
  std::size_t best_count = 0;
  for (int draw = 0; draw < options.draws; ++draw) {
    const auto [a, b, c] = DrawThree(points.size(), rng);
    const auto plane = PlaneThrough(points[a], points[b], points[c]);
    if (!plane) continue;
    const std::size_t count = base::CountToBeat(points, best_count, [&](const Eigen::Vector3d& p) {
      return std::abs(plane->Distance(p)) <= options.inlier_distance_m;
    });
    if (count > best_count) {
      best = plane;
      best_count = count;
    }
  }
  if (!best) return std::nullopt;
  const Indices inliers = Inliers(points, *best, options.inlier_distance_m);
  const auto refitted = FitPlane(Select(points, inliers));
  PlaneFit fit;
  fit.plane = refitted.value_or(*best);
  fit.inliers = Inliers(points, fit.plane, options.inlier_distance_m);
  return fit;
}

}  // namespace rangegrasp::geometry
