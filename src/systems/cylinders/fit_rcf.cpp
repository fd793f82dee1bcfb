#include "cylinders/fit_rcf.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "cylinders/curvature.h"
#include "geometry/kd_tree.h"
#include "geometry/normals.h"

namespace rangegrasp::cylinders {
namespace {

/// A normal closer to the axis than 45 deg is of an end.
constexpr double kSquare = 0.7071;

/// CircleOnAxis ends after so many steps, or where one is below this share of the radius; a
/// distance below the floor, as a share of the radius, counts by its square.
constexpr int kCircleRounds = 40;
constexpr double kRestShare = 1e-9;
constexpr double kFloorShare = 1e-4;

void Check(const RcfOptions& options) {
  if (options.neighborhood_m <= 0.0 || options.tolerance_m <= 0.0 || options.barrel_rounds < 1) {
    throw std::invalid_argument(
        "RCF: neighborhood_m and tolerance_m must be > 0, barrel_rounds >= 1");
  }
}

/// Points of the wall with their normals.
struct WallPoints {
  geometry::Points points;
  geometry::Points normals;
};

WallPoints WallOf(const FitInput& input, const RcfPreparation& prepared, const Barrel& barrel,
                  double tolerance_m) {
  WallPoints wall;
  for (std::size_t i = 0; i < input.points.size(); ++i) {
    if (prepared.curved[i] || std::abs(barrel.Distance(input.points[i])) > tolerance_m) continue;
    // The seen end lies within the tolerance near its rim; its normals do not point to the axis.
    if (std::abs(prepared.normals[i].dot(barrel.axis.direction)) > kSquare) continue;
    wall.points.push_back(input.points[i]);
    wall.normals.push_back(prepared.normals[i]);
  }
  return wall;
}

}  // namespace

RcfOptions RcfAsPrinted() {
  RcfOptions options;
  options.gate = RimGate::kSigned;
  options.circle.distance = CircleDistance::kSphere;
  options.barrel_rounds = 1;
  options.circle_again = false;
  return options;
}

bool PassesGate(const Eigen::Vector3d& normal, const Eigen::Vector3d& up,
                const Eigen::Vector3d& to_eye, const RcfOptions& options) {
  const double n_x = normal.dot(up);
  if (options.gate == RimGate::kHalfway) {
    const double tilt = std::acos(std::clamp(n_x, -1.0, 1.0));
    return std::abs(tilt - base::Deg(45.0)) <= options.halfway_rad;
  }
  const Eigen::Vector3d y = to_eye.cross(up).stableNormalized();
  const double n_y = normal.dot(y);
  const double n_z = normal.dot(up.cross(y));
  if (options.gate == RimGate::kSigned) return PassesSensorGate({n_x, n_y, n_z});
  return n_x > std::abs(n_y) && n_x > std::abs(n_z);
}

RcfPreparation PrepareRcf(const FitInput& input, const RcfOptions& options) {
  Check(options);
  const geometry::KdTree tree(input.points);
  RcfPreparation prepared;
  const geometry::Points eye{input.eye};
  const std::vector<std::uint32_t> eye_of(input.points.size(), 0);
  geometry::NeighborLists neighbors;
  geometry::PointCloud cloud{{input.points.begin(), input.points.end()}, {}};
  cloud.normals = geometry::EstimateNormals(input.points, tree, options.neighborhood_m, eye, eye_of,
                                            0.0, &neighbors);
  CurvatureOptions curvature;
  curvature.radius_m = options.neighborhood_m;
  curvature.min_angle_rad = options.curvature_rad;
  prepared.curved = CurvedPoints(cloud, tree, curvature, neighbors);
  prepared.normals = std::move(cloud.normals);
  return prepared;
}

geometry::Indices RimOf(const FitInput& input, const RcfPreparation& prepared,
                        const RcfOptions& options) {
  geometry::Indices rim;
  for (std::size_t i = 0; i < input.points.size(); ++i) {
    if (prepared.curved[i] &&
        PassesGate(prepared.normals[i], input.up, input.eye - input.points[i], options)) {
      rim.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return rim;
}

std::optional<Circle> CircleOnAxis(geometry::PointSpan rim, const Eigen::Vector3d& axis,
                                   const Circle& start) {
  if (rim.size() < 3) return std::nullopt;
  const Eigen::Vector3d u = axis.unitOrthogonal();
  const Eigen::Vector3d v = axis.cross(u);
  Circle circle{start.center, axis, start.radius_m};
  for (int round = 0; round < kCircleRounds; ++round) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : rim) {
      const Eigen::Vector2d offset((p - circle.center).dot(u), (p - circle.center).dot(v));
      const double distance = offset.norm();
      if (distance == 0.0) continue;
      const double error = distance - circle.radius_m;
      const Eigen::Vector3d row(-offset.x() / distance, -offset.y() / distance, -1.0);
      // The square over its root: the size. Below the floor squares count, so that no single point
      // that lies on the circle holds it.
      const double weight = 1.0 / std::max(std::abs(error), kFloorShare * start.radius_m);
      normal += weight * row * row.transpose();
      right -= weight * error * row;
    }
    const Eigen::Vector3d step = normal.ldlt().solve(right);
    if (!step.allFinite()) return std::nullopt;
    circle.center += step.x() * u + step.y() * v;
    circle.radius_m += step.z();
    if (!(circle.radius_m > 0.0)) return std::nullopt;
    if (step.norm() < kRestShare * start.radius_m) break;
  }
  return circle;
}

std::optional<BarrelFit> FitRcf(const FitInput& input, const RcfPreparation& prepared,
                                const RcfOptions& options, base::Rng& rng) {
  Check(options);
  const geometry::Points rim = geometry::Select(input.points, RimOf(input, prepared, options));
  const auto drawn = FitRandomCircle(rim, options.circle, rng);
  if (!drawn) return std::nullopt;
  Circle circle = drawn->circle;
  Barrel barrel{{circle.center, circle.normal}, circle.radius_m};
  for (int round = 0; round < options.barrel_rounds; ++round) {
    const WallPoints wall = WallOf(input, prepared, barrel, options.tolerance_m);
    const auto line = FitLine(AxisPoints(wall.points, wall.normals, barrel.radius_m));
    if (!line) return std::nullopt;
    barrel.axis = *line;
    if (!options.circle_again) continue;
    const auto again = CircleOnAxis(rim, line->direction, circle);
    if (!again) return std::nullopt;
    circle = *again;
    barrel.radius_m = circle.radius_m;
  }
  return BarrelFit{barrel, options.circle.draws};
}

}  // namespace rangegrasp::cylinders
