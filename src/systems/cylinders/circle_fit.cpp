#include "cylinders/circle_fit.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace rangegrasp::cylinders {
namespace {

/// Twice a triangle's area, squared, to the product of its two longer sides, squared: below it the
/// corners are collinear to what double precision of coordinates about a metre can say.
constexpr double kCollinear = 1e-12;

}  // namespace

TriangleProducts ProductsOf(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c) {
  TriangleProducts products;
  products.d_ca = (c - a).dot(b - a);
  products.d_ba = (c - b).dot(a - b);
  products.d_cb = (a - c).dot(b - c);
  products.n_1 = products.d_ba * products.d_cb;
  products.n_2 = products.d_cb * products.d_ca;
  products.n_3 = products.d_ca * products.d_ba;
  return products;
}

double CircumradiusOf(const TriangleProducts& p) {
  return 0.5 * std::sqrt((p.d_ca + p.d_ba) * (p.d_ba + p.d_cb) * (p.d_cb + p.d_ca) / p.Sum());
}

std::optional<Circle> CircleThrough(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c) {
  const TriangleProducts p = ProductsOf(a, b, c);
  const double sum = p.Sum();
  const double sides = p.d_ca + p.d_ba + p.d_cb;  // half the sum of the squared sides
  if (!(sum > kCollinear * sides * sides)) return std::nullopt;
  Circle circle;
  circle.center = ((p.n_2 + p.n_3) * a + (p.n_3 + p.n_1) * b + (p.n_1 + p.n_2) * c) / (2.0 * sum);
  circle.normal = (b - a).cross(c - a).normalized();
  circle.radius_m = CircumradiusOf(p);
  return circle;
}

double AreaOf(const Circle& circle) { return circle.radius_m * circle.radius_m * std::numbers::pi; }

double CircumferenceOf(const Circle& circle) { return 2.0 * circle.radius_m * std::numbers::pi; }

double DistanceTo(const Circle& circle, const Eigen::Vector3d& p, CircleDistance distance) {
  const Eigen::Vector3d from_center = p - circle.center;
  if (distance == CircleDistance::kSphere) return std::abs(from_center.norm() - circle.radius_m);
  const double off_plane = from_center.dot(circle.normal);
  const double in_plane = (from_center - off_plane * circle.normal).norm();
  return std::hypot(in_plane - circle.radius_m, off_plane);
}

double SumOfDistances(const Circle& circle, geometry::PointSpan rim, CircleDistance distance,
                      double enough_m) {
  double sum_m = 0.0;
  for (const Eigen::Vector3d& p : rim) {
    sum_m += DistanceTo(circle, p, distance);
    if (sum_m > enough_m) break;
  }
  return sum_m;
}

double ShareOn(const Circle& circle, geometry::PointSpan rim, CircleDistance distance,
               double tolerance_m) {
  if (rim.empty()) return 0.0;
  std::size_t on = 0;
  for (const Eigen::Vector3d& p : rim) on += DistanceTo(circle, p, distance) <= tolerance_m;
  return static_cast<double>(on) / static_cast<double>(rim.size());
}

std::optional<RandomCircle> FitRandomCircle(geometry::PointSpan rim,
                                            const RandomCircleOptions& options, base::Rng& rng) {
  if (options.draws < 1) throw std::invalid_argument("draws must be at least 1");
  if (rim.size() < 3) return std::nullopt;
  std::optional<RandomCircle> best;
  int drawn = 0;
  for (int draw = 0; draw < options.draws; ++draw) {
    const std::size_t a = rng.Index(rim.size());
    const std::size_t b = rng.Index(rim.size());
    const std::size_t c = rng.Index(rim.size());
    const auto circle = CircleThrough(rim[a], rim[b], rim[c]);  // none where one is drawn twice
    if (!circle) continue;
    ++drawn;
    const double enough_m = best ? best->sum_m : std::numeric_limits<double>::infinity();
    const double sum_m = SumOfDistances(*circle, rim, options.distance, enough_m);
    if (!best || sum_m < best->sum_m) best = RandomCircle{*circle, sum_m, 0};
  }
  if (best) best->drawn = drawn;
  return best;
}

}  // namespace rangegrasp::cylinders
