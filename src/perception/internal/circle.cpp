#include "perception/internal/circle.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/count_to_beat.h"
#include "base/units.h"
#include "geometry/plane.h"

namespace rangegrasp::perception::internal {
namespace {

/// Squared sine, and its like for the scatter of points, below which points count as collinear: far
/// above rounding, far below what noise makes of a line.
constexpr double kCollinearThree = 1e-18;
constexpr double kCollinearMany = 1e-12;
/// Bins of an arc, 10 deg each: a rim of 35 mm radius has three points in one. Fewer bins count a
/// few points as a long arc, more count the gaps between points.
constexpr int kArcBins = 36;

geometry::Indices Inliers(const Circle& circle, geometry::PointSpan rim, double distance_m) {
  geometry::Indices inliers;
  for (std::size_t i = 0; i < rim.size(); ++i) {
    if (CircleDistance(circle, rim[i]) <= distance_m) {
      inliers.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return inliers;
}

/// Least squares in the plane of the inliers; nullopt if they do not span one.
std::optional<Circle> Refit(geometry::PointSpan inliers) {
  const auto plane = geometry::FitPlane(inliers);
  if (!plane) return std::nullopt;
  const Eigen::Vector3d origin = geometry::Centroid(inliers);
  const Eigen::Vector3d u = plane->normal.unitOrthogonal();
  const Eigen::Vector3d v = plane->normal.cross(u);
  std::vector<Eigen::Vector2d> flat;
  flat.reserve(inliers.size());
  for (const Eigen::Vector3d& p : inliers) {
    flat.emplace_back((p - origin).dot(u), (p - origin).dot(v));
  }
  const auto fit = FitCircle2(flat);
  if (!fit) return std::nullopt;
  return Circle{origin + fit->center.x() * u + fit->center.y() * v, plane->normal, fit->radius_m};
}

}  // namespace

std::optional<Circle> CircleThrough(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c) {
  const Eigen::Vector3d u = b - a;
  const Eigen::Vector3d v = c - a;
  const Eigen::Vector3d w = u.cross(v);
  const double uu = u.squaredNorm();
  const double vv = v.squaredNorm();
  const double ww = w.squaredNorm();
  if (!(ww > kCollinearThree * uu * vv) || ww == 0.0) return std::nullopt;
  const Eigen::Vector3d offset = (uu * v.cross(w) + vv * w.cross(u)) / (2.0 * ww);
  return Circle{a + offset, w / std::sqrt(ww), offset.norm()};
}

double CircleDistance(const Circle& circle, const Eigen::Vector3d& p) {
  const Eigen::Vector3d d = p - circle.center;
  const double off_plane = d.dot(circle.normal);
  const double off_curve = (d - off_plane * circle.normal).norm() - circle.radius_m;
  return std::max(std::abs(off_plane), std::abs(off_curve));
}

std::optional<Circle2> FitCircle2(std::span<const Eigen::Vector2d> points) {
  if (points.size() < 3) return std::nullopt;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  // |q|^2 = 2 q . c + k for q relative to the mean, least squares in c and k.
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  double squares = 0.0;
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2d q = p - mean;
    scatter += q * q.transpose();
    moment += q.squaredNorm() * q;
    squares += q.squaredNorm();
  }
  if (!(scatter.determinant() > kCollinearMany * squares * squares)) return std::nullopt;
  const Eigen::Vector2d center = 0.5 * scatter.inverse() * moment;
  const double radius =
      std::sqrt(center.squaredNorm() + squares / static_cast<double>(points.size()));
  return Circle2{mean + center, radius};
}

std::optional<CircleFit> FitCircle(geometry::PointSpan rim, const CircleFitOptions& options,
                                   base::Rng& rng) {
  if (rim.size() < 3) return std::nullopt;
  std::optional<Circle> best;
  std::size_t best_count = 0;
  for (int draw = 0; draw < options.draws; ++draw) {
    const std::size_t a = rng.Index(rim.size());
    const std::size_t b = rng.Index(rim.size());
    const std::size_t c = rng.Index(rim.size());
    const auto circle = CircleThrough(rim[a], rim[b], rim[c]);
    if (!circle || circle->radius_m > options.max_radius_m) continue;
    const std::size_t count = base::CountToBeat(rim, best_count, [&](const Eigen::Vector3d& p) {
      return CircleDistance(*circle, p) <= options.distance_m;
    });
    if (count > best_count) {
      best_count = count;
      best = circle;
    }
  }
  if (!best) return std::nullopt;
  CircleFit fit{*best, Inliers(*best, rim, options.distance_m)};
  for (int round = 0; round < options.refits; ++round) {
    const auto refit = Refit(geometry::Select(rim, fit.inliers));
    if (!refit || refit->radius_m > options.max_radius_m) break;
    auto inliers = Inliers(*refit, rim, options.distance_m);
    if (static_cast<double>(inliers.size()) <
        options.refit_share * static_cast<double>(fit.inliers.size())) {
      break;
    }
    fit = {*refit, std::move(inliers)};
  }
  return fit;
}

double ArcOf(const geometry::PointCloud& cloud, const geometry::Indices& points,
             const Circle& circle) {
  const Eigen::Vector3d u = circle.normal.unitOrthogonal();
  const Eigen::Vector3d v = circle.normal.cross(u);
  std::vector<bool> seen(kArcBins, false);
  for (const auto i : points) {
    const Eigen::Vector3d d = cloud.points[i] - circle.center;
    const double turn = std::atan2(d.dot(v), d.dot(u)) / (2.0 * base::kPi) + 0.5;
    seen[std::min<std::size_t>(kArcBins - 1, static_cast<std::size_t>(turn * kArcBins))] = true;
  }
  return 2.0 * base::kPi * static_cast<double>(std::count(seen.begin(), seen.end(), true)) /
         kArcBins;
}

double AxisDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& c, const Eigen::Vector3d& n) {
  return (p - c).cross(n).norm();
}

}  // namespace rangegrasp::perception::internal
