#include "cylinders/cylinder.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <stdexcept>

#include "base/statistics.h"

namespace rangegrasp::cylinders {
namespace {

/// A line that meets a plane at less than this sine has no point in it worth naming.
constexpr double kInPlane = 1e-6;

/// A point further from a line than this many median distances is left out of the next fit. Larger:
/// more of them count.
constexpr double kTrim = 3.0;
constexpr int kTrimRounds = 5;  // ends where none changes

/// Distance [m] of p from the surface of the closed cylinder.
double SurfaceDistance(const Cylinder& cylinder, const Eigen::Vector3d& p) {
  const Eigen::Vector3d offset = p - cylinder.center;
  const double along = offset.dot(cylinder.axis);
  const double out = (offset - along * cylinder.axis).norm() - cylinder.radius_m;
  const double beyond = std::abs(along) - 0.5 * cylinder.height_m;
  if (out <= 0.0 && beyond <= 0.0) return std::min(-out, -beyond);
  return std::hypot(std::max(out, 0.0), std::max(beyond, 0.0));
}

bool IsInside(const Cylinder& cylinder, const Eigen::Vector3d& p) {
  const Eigen::Vector3d offset = p - cylinder.center;
  const double along = offset.dot(cylinder.axis);
  return std::abs(along) <= 0.5 * cylinder.height_m &&
         (offset - along * cylinder.axis).norm() <= cylinder.radius_m;
}

}  // namespace

geometry::Points AxisPoints(geometry::PointSpan barrel, geometry::PointSpan outward_normals,
                            double radius_m) {
  if (barrel.size() != outward_normals.size()) {
    throw std::invalid_argument("axis points need one normal a point");
  }
  geometry::Points points;
  points.reserve(barrel.size());
  for (std::size_t i = 0; i < barrel.size(); ++i) {
    points.push_back(AxisPoint(barrel[i], outward_normals[i], radius_m));
  }
  return points;
}

std::optional<Line> FitLine(geometry::PointSpan points) {
  if (points.size() < 2) return std::nullopt;
  Line line;
  line.point = geometry::Centroid(points);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d offset = p - line.point;
    covariance += offset * offset.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  if (!(solver.eigenvalues().z() > 0.0)) return std::nullopt;
  line.direction = solver.eigenvectors().col(2).normalized();
  return line;
}

std::optional<Line> FitTrimmedLine(geometry::PointSpan points) {
  std::optional<Line> line = FitLine(points);
  std::size_t before = points.size();
  for (int round = 0; line && round < kTrimRounds; ++round) {
    std::vector<double> distances;
    distances.reserve(points.size());
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

std::optional<Entry> EntryOf(const Eigen::Vector3d& origin, const Eigen::Vector3d& target,
                             const Cylinder& cylinder) {
  const Eigen::Vector3d way = target - origin;
  const Eigen::Vector3d from = origin - cylinder.center;
  const double along_way = way.dot(cylinder.axis);
  const double along_from = from.dot(cylinder.axis);
  const Eigen::Vector3d across_way = way - along_way * cylinder.axis;
  const Eigen::Vector3d across_from = from - along_from * cylinder.axis;
  // Where the ray is within the barrel's round, then within its ends.
  const double a = across_way.squaredNorm();
  const double b = across_way.dot(across_from);
  const double c = across_from.squaredNorm() - cylinder.radius_m * cylinder.radius_m;
  double enters_round = -std::numeric_limits<double>::infinity();
  double leaves_round = std::numeric_limits<double>::infinity();
  if (a > 0.0) {
    const double discriminant = b * b - a * c;
    if (discriminant <= 0.0) return std::nullopt;
    enters_round = (-b - std::sqrt(discriminant)) / a;
    leaves_round = (-b + std::sqrt(discriminant)) / a;
  } else if (c > 0.0) {
    return std::nullopt;
  }
  const double half = 0.5 * cylinder.height_m;
  double enters_ends = -std::numeric_limits<double>::infinity();
  double leaves_ends = std::numeric_limits<double>::infinity();
  if (along_way != 0.0) {
    const double one = (-half - along_from) / along_way;
    const double other = (half - along_from) / along_way;
    enters_ends = std::min(one, other);
    leaves_ends = std::max(one, other);
  } else if (std::abs(along_from) > half) {
    return std::nullopt;
  }
  const double enters = std::max(enters_round, enters_ends);
  if (enters <= 0.0 || enters >= std::min(leaves_round, leaves_ends)) return std::nullopt;
  return Entry{enters, enters_ends > enters_round};
}

ViewCounts CompareWithView(geometry::PointSpan points, geometry::PointSpan places,
                           std::span<const std::uint32_t> place_of, const Cylinder& cylinder,
                           double tolerance_m, const std::vector<bool>& left_out) {
  Cylinder smaller = cylinder;
  smaller.radius_m = std::max(0.0, cylinder.radius_m - tolerance_m);
  smaller.height_m = std::max(0.5 * cylinder.height_m, cylinder.height_m - 2.0 * tolerance_m);
  const double bound_m = std::hypot(cylinder.radius_m, 0.5 * cylinder.height_m) + tolerance_m;
  ViewCounts counts;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!left_out.empty() && left_out[i]) continue;
    const Eigen::Vector3d& origin = places[place_of[i]];
    const Eigen::Vector3d way = points[i] - origin;
    const Eigen::Vector3d to_center = cylinder.center - origin;
    if (way.cross(to_center).squaredNorm() > bound_m * bound_m * way.squaredNorm()) continue;
    if (SurfaceDistance(cylinder, points[i]) <= tolerance_m) {
      ++counts.on;
      continue;
    }
    const auto entry = EntryOf(origin, points[i], smaller);
    if (!entry) continue;
    if (entry->share >= 1.0) {
      ++counts.before;
    } else if (!entry->by_end || !IsInside(cylinder, points[i])) {
      ++counts.through;
    }
  }
  return counts;
}

RaysThrough ChooseRays(geometry::PointSpan points, geometry::PointSpan places,
                       std::span<const std::uint32_t> place_of, const Eigen::Vector3d& center,
                       double radius_m) {
  RaysThrough rays{center, radius_m, {}, {}, {}};
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d& origin = places[place_of[i]];
    const Eigen::Vector3d way = points[i] - origin;
    const Eigen::Vector3d to_center = center - origin;
    if (way.cross(to_center).squaredNorm() > radius_m * radius_m * way.squaredNorm()) continue;
    rays.chosen.push_back(i);
    rays.points.push_back(points[i]);
    rays.place_of.push_back(place_of[i]);
  }
  return rays;
}

std::vector<bool> PointsOn(geometry::PointSpan points, const Cylinder& cylinder,
                           double tolerance_m) {
  const double bound_m = std::hypot(cylinder.radius_m, 0.5 * cylinder.height_m) + tolerance_m;
  std::vector<bool> on(points.size(), false);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if ((points[i] - cylinder.center).squaredNorm() > bound_m * bound_m) continue;
    on[i] = SurfaceDistance(cylinder, points[i]) <= tolerance_m;
  }
  return on;
}

}  // namespace rangegrasp::cylinders
