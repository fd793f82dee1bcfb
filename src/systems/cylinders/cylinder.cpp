#include "cylinders/cylinder.h"

#include <Eigen/Geometry>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>
#include <vector>

#include "base/linear_algebra.h"
#include "base/statistics.h"
#include "geometry/plane.h"

namespace rangegrasp::cylinders {
namespace {

/// A line at less than this sine to a plane has no usable intersection with it.
constexpr double kInPlane = 1e-6;

/// Points further from a line than this many median distances are left out of the next fit.
constexpr double kTrim = 3.0;
constexpr int kTrimRounds = 5;  // stops early if the set of points stays the same

/// Radius about its center of a sphere that contains the cylinder grown by `grown_m`.
double BoundOf(const Cylinder& cylinder, double grown_m) {
  return std::hypot(cylinder.radius_m, 0.5 * cylinder.height_m) + grown_m;
}

/// True if the line from the origin through p meets the sphere.
bool Meets(const Eigen::Vector3d& origin, const Eigen::Vector3d& p, const Eigen::Vector3d& center,
           double radius_m) {
  const Eigen::Vector3d way = p - origin;
  return way.cross(center - origin).squaredNorm() <= radius_m * radius_m * way.squaredNorm();
}

/// Distance [m] of p from the surface of the closed cylinder.
double SurfaceDistance(const Cylinder& cylinder, const Eigen::Vector3d& p) {
  const About about(cylinder.center, cylinder.axis, p);
  const double out = about.radial_m - cylinder.radius_m;
  const double beyond = std::abs(about.along_m) - 0.5 * cylinder.height_m;
  if (out <= 0.0 && beyond <= 0.0) return std::min(-out, -beyond);
  return std::hypot(std::max(out, 0.0), std::max(beyond, 0.0));
}

}  // namespace

geometry::Points AxisPoints(geometry::PointSpan barrel, geometry::PointSpan outward_normals,
                            double radius_m) {
  geometry::Points points;
  std::ranges::transform(
      barrel, outward_normals, std::back_inserter(points),
      [&](const auto& p, const auto& normal) { return AxisPoint(p, normal, radius_m); });
  return points;
}

std::optional<Line> FitLine(geometry::PointSpan points) {
  if (points.size() < 2) return std::nullopt;
  Line line;
  line.point = geometry::Centroid(points);
  const auto axes = base::SymmetricEigen(geometry::Scatter(points, line.point));
  if (!(axes.values.z() > 0.0)) return std::nullopt;
  line.direction = axes.vectors.col(2).normalized();
  return line;
}

std::optional<Line> FitTrimmedLine(geometry::PointSpan points) {
  std::optional<Line> line = FitLine(points);
  std::size_t before = points.size();
  for (int round = 0; line && round < kTrimRounds; ++round) {
    std::vector<double> distances;
    for (const Eigen::Vector3d& p : points) distances.push_back(line->Distance(p));
    const double limit_m = kTrim * base::MedianOf(distances);
    geometry::Points near;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (distances[i] <= limit_m) near.push_back(points[i]);
    }
    if (near.size() == before || near.size() < 2) break;
    before = near.size();
    if (const auto next = FitLine(near)) line = next;
  }
  return line;
}

std::optional<Eigen::Vector3d> CenterOnAxis(const Line& axis, geometry::PointSpan rim,
                                            const Eigen::Vector3d& normal) {
  const double slope = axis.direction.dot(normal);
  if (rim.empty() || std::abs(slope) < kInPlane) return std::nullopt;
  const double along = (geometry::Centroid(rim) - axis.point).dot(normal) / slope;
  return axis.point + along * axis.direction;
}

std::optional<Entry> EntryOf(const Eigen::Vector3d& origin, const Eigen::Vector3d& way_to,
                             const Cylinder& cylinder) {
  const About from(cylinder.center, cylinder.axis, origin);
  const About way(Eigen::Vector3d::Zero(), cylinder.axis, way_to);
  // Interval of the ray inside the infinite barrel, then between the planes of the ends.
  const double a = way.radial.squaredNorm();
  const double b = way.radial.dot(from.radial);
  const double c = from.radial.squaredNorm() - cylinder.radius_m * cylinder.radius_m;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double enters_round = -kInfinity, leaves_round = kInfinity;
  if (a > 0.0) {
    const double discriminant = b * b - a * c;
    if (discriminant <= 0.0) return std::nullopt;
    enters_round = (-b - std::sqrt(discriminant)) / a;
    leaves_round = (-b + std::sqrt(discriminant)) / a;
  } else if (c > 0.0) {
    return std::nullopt;
  }
  const double half = 0.5 * cylinder.height_m;
  double enters_ends = -kInfinity, leaves_ends = kInfinity;
  if (way.along_m != 0.0) {
    std::tie(enters_ends, leaves_ends) =
        std::minmax({(-half - from.along_m) / way.along_m, (half - from.along_m) / way.along_m});
  } else if (std::abs(from.along_m) > half) {
    return std::nullopt;
  }
  const double enters = std::max(enters_round, enters_ends);
  if (enters <= 0.0 || enters >= std::min(leaves_round, leaves_ends)) return std::nullopt;
  return Entry{enters, enters_ends > enters_round};
}

bool IsWithin(const Cylinder& cylinder, double grown_m, const Eigen::Vector3d& p) {
  const About about(cylinder.center, cylinder.axis, p);
  return std::abs(about.along_m) <= 0.5 * cylinder.height_m + grown_m &&
         about.radial_m <= cylinder.radius_m + grown_m;
}

geometry::Indices PointsOn(geometry::PointSpan points, const Cylinder& cylinder,
                           double tolerance_m) {
  const double bound_m = BoundOf(cylinder, tolerance_m);
  return geometry::PositionsWhere(points, [&](const Eigen::Vector3d& p) {
    return (p - cylinder.center).squaredNorm() <= bound_m * bound_m &&
           SurfaceDistance(cylinder, p) <= tolerance_m;
  });
}

ViewCounts CompareWithView(const Rays& rays, const Cylinder& cylinder, double tolerance_m,
                           const Cylinder* left_out) {
  Cylinder smaller = cylinder;
  smaller.radius_m = std::max(0.0, cylinder.radius_m - tolerance_m);
  smaller.height_m = std::max(0.5 * cylinder.height_m, cylinder.height_m - 2.0 * tolerance_m);
  const double bound_m = BoundOf(cylinder, tolerance_m);
  ViewCounts counts;
  for (std::size_t i = 0; i < rays.points.size(); ++i) {
    const Eigen::Vector3d& p = rays.points[i];
    const Eigen::Vector3d& origin = rays.places[rays.place_of[i]];
    if (!Meets(origin, p, cylinder.center, bound_m)) continue;
    if (left_out && SurfaceDistance(*left_out, p) <= tolerance_m) continue;
    if (SurfaceDistance(cylinder, p) <= tolerance_m) {
      ++counts.on;
      continue;
    }
    const auto entry = EntryOf(origin, p - origin, smaller);
    if (!entry) continue;
    if (entry->share >= 1.0) {
      ++counts.before;
    } else if (!entry->by_end || !IsWithin(cylinder, 0.0, p)) {
      ++counts.through;
    }
  }
  return counts;
}

RaysThrough::RaysThrough(const Rays& all, const Eigen::Vector3d& center_, double radius_m_)
    : center(center_), radius_m(radius_m_), places(all.places) {
  for (std::size_t i = 0; i < all.points.size(); ++i) {
    if (!Meets(places[all.place_of[i]], all.points[i], center, radius_m)) continue;
    points.push_back(all.points[i]);
    place_of.push_back(all.place_of[i]);
  }
}

bool RaysThrough::AreAllOf(const Cylinder& cylinder, double tolerance_m) const {
  return (cylinder.center - center).norm() + BoundOf(cylinder, tolerance_m) < radius_m;
}

}  // namespace rangegrasp::cylinders
