#include "perception/internal/planar.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "base/linear_algebra.h"

namespace rangegrasp::perception::internal {
namespace {

/// A hint whose part in the plane is this short (squared) is normal to the plane, up to rounding.
constexpr double kNoDirection = 1e-12;

double SegmentDistance(const Vector2d& a, const Vector2d& b, const Vector2d& q) {
  const Vector2d ab = b - a;
  const double squared = ab.squaredNorm();
  const double t = squared > 0.0 ? std::clamp((q - a).dot(ab) / squared, 0.0, 1.0) : 0.0;
  return (q - a - t * ab).norm();
}

/// For a squared sine and for a scatter: far above rounding, far below what noise makes of a line.
constexpr double kCollinearThree = 1e-18;
constexpr double kCollinearMany = 1e-12;
/// Bins of an arc, 10 deg each: on a rim of 35 mm radius, one bin has three points. Fewer bins
/// count a few points as a long arc, more count the gaps between points.
constexpr int kArcBins = 36;

Indices Inliers(const Circle& circle, PointSpan rim, double distance_m) {
  return geometry::PositionsWhere(
      rim, [&](const Vector3d& p) { return CircleDistance(circle, p) <= distance_m; });
}

/// Least squares in the plane of the inliers; nullopt if they do not span one.
std::optional<Circle> Refit(PointSpan inliers) {
  const auto plane = geometry::FitPlane(inliers);
  if (!plane) return std::nullopt;
  const Vector3d u = plane->normal.unitOrthogonal();
  const PlanarFrame frame{geometry::Centroid(inliers), u, plane->normal.cross(u), plane->normal};
  const auto fit = FitCircle2(Flatten(frame, inliers));
  if (!fit) return std::nullopt;
  return Circle{frame.Lift(fit->center), plane->normal, fit->radius_m};
}

}  // namespace

PlanarFrame MakePlanarFrame(const Plane& plane, const Vector3d& near, const Vector3d& hint) {
  Vector3d u = hint - hint.dot(plane.normal) * plane.normal;
  if (u.squaredNorm() < kNoDirection) u = plane.normal.unitOrthogonal();
  u.normalize();
  return {plane.Project(near), u, plane.normal.cross(u), plane.normal};
}

std::vector<Vector2d> Flatten(const PlanarFrame& frame, PointSpan points) {
  std::vector<Vector2d> flat(points.size());
  std::ranges::transform(points, flat.begin(), [&](const Vector3d& p) { return frame.Flat(p); });
  return flat;
}

std::vector<std::uint32_t> HullPositions(std::span<const Vector2d> points) {
  const Indices order = geometry::CanonicalOrder(points);
  if (order.size() < 3) return order;
  std::vector<std::uint32_t> hull;
  const auto extend = [&](std::uint32_t i, std::size_t floor) {
    while (hull.size() >= floor + 2 && Cross(points[hull.back()] - points[hull[hull.size() - 2]],
                                             points[i] - points[hull[hull.size() - 2]]) <= 0.0) {
      hull.pop_back();
    }
    hull.push_back(i);
  };
  for (const std::uint32_t i : order) extend(i, 0);
  const std::size_t lower = hull.size() - 1;
  for (auto it = order.rbegin() + 1; it != order.rend(); ++it) extend(*it, lower);
  hull.pop_back();
  return hull;
}

Rectangle RectangleAlong(std::span<const Vector2d> points, const Vector2d& axis) {
  if (points.empty()) return {};
  const Vector2d across(-axis.y(), axis.x());
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array2d high = -low;
  for (const Vector2d& p : points) {
    const Eigen::Array2d q(p.dot(axis), p.dot(across));
    low = low.min(q);
    high = high.max(q);
  }
  const Eigen::Array2d middle = 0.5 * (low + high);
  return {middle.x() * axis + middle.y() * across, axis, high.x() - low.x(), high.y() - low.y()};
}

Rectangle MinAreaRectangle(std::span<const Vector2d> points) {
  const std::vector<Vector2d> hull = ConvexPolygon::Around(points).corners;
  Rectangle best = RectangleAlong(hull, Vector2d::UnitX());
  double area = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vector2d side = hull[(i + 1) % hull.size()] - hull[i];
    if (side.squaredNorm() == 0.0) continue;
    const Rectangle r = RectangleAlong(hull, side.normalized());
    if (r.length_m * r.width_m < area) {
      area = r.length_m * r.width_m;
      best = r;
    }
  }
  return best.LongerSideFirst();
}

Rectangle PrincipalRectangle(std::span<const Vector2d> points) {
  Vector2d mean = Vector2d::Zero();
  for (const Vector2d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const Vector2d& p : points) covariance += (p - mean) * (p - mean).transpose();
  return RectangleAlong(points, base::SymmetricEigen(covariance).vectors.col(1));
}

double HighestLine(const PlanarFrame& frame, const Plane& table, PointSpan points) {
  // Two and a half point spacings: each slice has some points, and a short edge has some slices.
  constexpr double kSlice_m = 0.005;
  std::map<long, std::pair<double, double>> slices;  // height and offset of the highest
  for (const auto& p : points) {
    const Vector2d q = frame.Flat(p);
    const double height = table.Distance(p);
    auto [it, fresh] = slices.try_emplace(std::lround(q.x() / kSlice_m), height, q.y());
    if (!fresh && height > it->second.first) it->second = {height, q.y()};
  }
  std::vector<double> offsets;
  for (const auto& [slice, highest] : slices) offsets.push_back(highest.second);
  return base::UpperMedianOf(std::move(offsets));
}

double SupportedEnd(std::vector<double> values, std::size_t others, double band_m) {
  std::ranges::sort(values);
  for (std::size_t k = values.size(); k-- > others;) {
    if (values[k - others] >= values[k] - band_m) return values[k];
  }
  return values.back();
}

double FilledArea(std::span<const Vector2d> points, double cell_m) {
  std::set<std::pair<long, long>> cells;
  for (const auto& q : points) {
    cells.emplace(std::lround(q.x() / cell_m), std::lround(q.y() / cell_m));
  }
  return static_cast<double>(cells.size()) * cell_m * cell_m;
}

ConvexPolygon ConvexPolygon::Around(std::span<const Vector2d> points) {
  ConvexPolygon polygon;
  for (const std::uint32_t i : HullPositions(points)) polygon.corners.push_back(points[i]);
  return polygon;
}

double ConvexPolygon::Area() const {
  double twice = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    twice += Cross(corners[i], corners[(i + 1) % corners.size()]);
  }
  return 0.5 * twice;
}

double ConvexPolygon::Distance(const Vector2d& q) const {
  const auto next = [&](std::size_t i) { return i + 1 == corners.size() ? 0 : i + 1; };
  bool inside = corners.size() >= 3;
  for (std::size_t i = 0; inside && i < corners.size(); ++i) {
    inside = Cross(corners[next(i)] - corners[i], q - corners[i]) >= 0.0;
  }
  if (inside) return 0.0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    nearest = std::min(nearest, SegmentDistance(corners[i], corners[next(i)], q));
  }
  return nearest;
}

std::optional<Circle> CircleThrough(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d u = b - a;
  const Vector3d v = c - a;
  const Vector3d w = u.cross(v);
  const double uu = u.squaredNorm();
  const double vv = v.squaredNorm();
  const double ww = w.squaredNorm();
  if (!(ww > kCollinearThree * uu * vv) || ww == 0.0) return std::nullopt;
  const Vector3d offset = (uu * v.cross(w) + vv * w.cross(u)) / (2.0 * ww);
  return Circle{a + offset, w / std::sqrt(ww), offset.norm()};
}

double CircleDistance(const Circle& circle, const Vector3d& p) {
  const Vector3d d = p - circle.center;
  const double off_plane = d.dot(circle.normal);
  const double off_curve = (d - off_plane * circle.normal).norm() - circle.radius_m;
  return std::max(std::abs(off_plane), std::abs(off_curve));
}

std::optional<Circle2> FitCircle2(std::span<const Vector2d> points) {
  if (points.size() < 3) return std::nullopt;
  Vector2d mean = Vector2d::Zero();
  for (const Vector2d& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  // |q|^2 = 2 q . c + k for q relative to the mean, least squares in c and k.
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  Vector2d moment = Vector2d::Zero();
  double squares = 0.0;
  for (const Vector2d& p : points) {
    const Vector2d q = p - mean;
    scatter += q * q.transpose();
    moment += q.squaredNorm() * q;
    squares += q.squaredNorm();
  }
  if (!(scatter.determinant() > kCollinearMany * squares * squares)) return std::nullopt;
  const Vector2d center = 0.5 * scatter.inverse() * moment;
  const double radius =
      std::sqrt(center.squaredNorm() + squares / static_cast<double>(points.size()));
  return Circle2{mean + center, radius};
}

std::optional<CircleFit> FitCircle(PointSpan rim, const CircleFitOptions& options, base::Rng& rng) {
  if (rim.size() < 3) return std::nullopt;
  const auto draw = [&] {
    const std::size_t a = rng.Index(rim.size());
    const std::size_t b = rng.Index(rim.size());
    const std::size_t c = rng.Index(rim.size());
    const auto circle = CircleThrough(rim[a], rim[b], rim[c]);
    return circle && circle->radius_m <= options.max_radius_m ? circle : std::nullopt;
  };
  const auto is_on = [&](const Circle& circle, const Vector3d& p) {
    return CircleDistance(circle, p) <= options.distance_m;
  };
  const auto best = BestOfDraws(options.draws, draw, rim, is_on).first;
  if (!best) return std::nullopt;
  CircleFit fit{*best, Inliers(*best, rim, options.distance_m)};
  for (int round = 0; round < options.refits; ++round) {
    const auto refit = Refit(Select(rim, fit.inliers));
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

double ArcOf(const PointCloud& cloud, const Indices& points, const Circle& circle) {
  const Vector3d u = circle.normal.unitOrthogonal();
  const Vector3d v = circle.normal.cross(u);
  std::vector<bool> seen(kArcBins, false);
  for (const auto i : points) {
    const Vector3d d = cloud.points[i] - circle.center;
    const double turn = std::atan2(d.dot(v), d.dot(u)) / (2.0 * base::kPi) + 0.5;
    seen[std::min<std::size_t>(kArcBins - 1, static_cast<std::size_t>(turn * kArcBins))] = true;
  }
  return 2.0 * base::kPi * static_cast<double>(std::ranges::count(seen, true)) / kArcBins;
}

double AxisDistance(const Vector3d& p, const Vector3d& c, const Vector3d& n) {
  return (p - c).cross(n).norm();
}

}  // namespace rangegrasp::perception::internal
