#include "perception/internal/planar.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "base/quantile.h"

namespace rangegrasp::perception::internal {
namespace {

/// A hint whose part in the plane is this short (squared) is square to it but for rounding.
constexpr double kNoDirection = 1e-12;

double SegmentDistance(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                       const Eigen::Vector2d& q) {
  const Eigen::Vector2d ab = b - a;
  const double squared = ab.squaredNorm();
  const double t = squared > 0.0 ? std::clamp((q - a).dot(ab) / squared, 0.0, 1.0) : 0.0;
  return (q - a - t * ab).norm();
}

}  // namespace

PlanarFrame MakePlanarFrame(const geometry::Plane& plane, const Eigen::Vector3d& near,
                            const Eigen::Vector3d& hint) {
  Eigen::Vector3d u = hint - hint.dot(plane.normal) * plane.normal;
  if (u.squaredNorm() < kNoDirection) u = plane.normal.unitOrthogonal();
  u.normalize();
  return {plane.Project(near), u, plane.normal.cross(u), plane.normal};
}

std::vector<Eigen::Vector2d> Flatten(const PlanarFrame& frame, geometry::PointSpan points) {
  std::vector<Eigen::Vector2d> flat;
  flat.reserve(points.size());
  for (const Eigen::Vector3d& p : points) flat.push_back(frame.Flat(p));
  return flat;
}

std::vector<std::uint32_t> HullPositions(std::span<const Eigen::Vector2d> points) {
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (points[a].x() != points[b].x()) return points[a].x() < points[b].x();
    if (points[a].y() != points[b].y()) return points[a].y() < points[b].y();
    return a < b;
  });
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

Rectangle RectangleAlong(std::span<const Eigen::Vector2d> points, const Eigen::Vector2d& axis) {
  if (points.empty()) return {};
  const Eigen::Vector2d across(-axis.y(), axis.x());
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array2d high = -low;
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Array2d q(p.dot(axis), p.dot(across));
    low = low.min(q);
    high = high.max(q);
  }
  const Eigen::Array2d middle = 0.5 * (low + high);
  return {middle.x() * axis + middle.y() * across, axis, high.x() - low.x(), high.y() - low.y()};
}

Rectangle MinAreaRectangle(std::span<const Eigen::Vector2d> points) {
  std::vector<Eigen::Vector2d> hull;
  for (const std::uint32_t i : HullPositions(points)) hull.push_back(points[i]);
  Rectangle best = RectangleAlong(hull, Eigen::Vector2d::UnitX());
  double area = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d side = hull[(i + 1) % hull.size()] - hull[i];
    if (side.squaredNorm() == 0.0) continue;
    const Rectangle r = RectangleAlong(hull, side.normalized());
    if (r.length_m * r.width_m < area) {
      area = r.length_m * r.width_m;
      best = r;
    }
  }
  if (best.width_m > best.length_m) {
    std::swap(best.width_m, best.length_m);
    best.axis = Eigen::Vector2d(-best.axis.y(), best.axis.x());
  }
  return best;
}

Rectangle PrincipalRectangle(std::span<const Eigen::Vector2d> points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& p : points) covariance += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance);
  return RectangleAlong(points, axes.eigenvectors().col(1));
}

double HighestLine(const PlanarFrame& frame, const geometry::Plane& table,
                   geometry::PointSpan points) {
  // Two and a half point spacings: each slice has some points, and a short edge some slices.
  constexpr double kSlice_m = 0.005;
  std::map<long, std::pair<double, double>> slices;  // height and offset of the highest
  for (const auto& p : points) {
    const Eigen::Vector2d q = frame.Flat(p);
    const double height = table.Distance(p);
    auto [it, fresh] = slices.try_emplace(std::lround(q.x() / kSlice_m), height, q.y());
    if (!fresh && height > it->second.first) it->second = {height, q.y()};
  }
  std::vector<double> offsets;
  for (const auto& [slice, highest] : slices) offsets.push_back(highest.second);
  return base::UpperMedianOf(std::move(offsets));
}

double SupportedEnd(std::vector<double> values, std::size_t others, double band_m) {
  std::sort(values.begin(), values.end());
  for (std::size_t k = values.size(); k-- > others;) {
    if (values[k - others] >= values[k] - band_m) return values[k];
  }
  return values.back();
}

double FilledArea(std::span<const Eigen::Vector2d> points, double cell_m) {
  std::set<std::pair<long, long>> cells;
  for (const auto& q : points) {
    cells.emplace(std::lround(q.x() / cell_m), std::lround(q.y() / cell_m));
  }
  return static_cast<double>(cells.size()) * cell_m * cell_m;
}

ConvexPolygon ConvexPolygon::Around(std::span<const Eigen::Vector2d> points) {
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

double ConvexPolygon::Distance(const Eigen::Vector2d& q) const {
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

}  // namespace rangegrasp::perception::internal
