#include "perception/internal/axis_from_body.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/count_to_beat.h"
#include "base/units.h"
#include "geometry/alpha_shape.h"
#include "perception/internal/circle.h"
#include "perception/internal/planar.h"
#include "perception/internal/top_surface.h"

namespace rangegrasp::perception::internal {
namespace {

using geometry::Indices;
using geometry::PointCloud;

/// A draw of two points and their normals is more often in vain than one of three rim points.
constexpr int kDrawsPerCircleDraw = 2;
/// Refits of the circle: the points that agree change a little with every one.
constexpr int kWallRefits = 5;

/// The circle about where the normals of two wall points meet, if they are about as far from there.
std::optional<Circle2> NormalsMeet(const Wall& a, const Wall& b, const FeatureOptions& options) {
  Eigen::Matrix2d directions;
  directions << -a.normal, b.normal;
  if (std::abs(directions.determinant()) < options.axis.min_normals_sine) return std::nullopt;
  const Eigen::Vector2d steps = directions.inverse() * (b.p - a.p);
  // p - step * normal: the center lies behind both, at the same distance but for the noise of both.
  if (steps.minCoeff() <= 0.0 || std::abs(steps[0] - steps[1]) > 2.0 * options.circle.distance_m) {
    return std::nullopt;
  }
  const Eigen::Vector2d center = 0.5 * (a.p - steps[0] * a.normal + b.p - steps[1] * b.normal);
  return Circle2{center, 0.5 * ((a.p - center).norm() + (b.p - center).norm())};
}

/// The least-squares circle (Kasa 1976: linear in center and r^2 - |center|^2) through the wall
/// points that agree.
Circle2 Refit(const std::vector<Wall>& walls, const Circle2& circle,
              const FeatureOptions& options) {
  Eigen::Matrix3d left = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Wall& wall : walls) {
    if (!IsOn(circle, wall, options)) continue;
    const Eigen::Vector2d d = wall.p - circle.center;
    const Eigen::Vector3d row(2.0 * d.x(), 2.0 * d.y(), 1.0);
    left += row * row.transpose();
    right += d.squaredNorm() * row;
  }
  const Eigen::Vector3d solved = left.ldlt().solve(right);
  const double squared = solved[2] + solved.head<2>().squaredNorm();
  if (!solved.allFinite() || squared <= 0.0) return circle;
  return {circle.center + solved.head<2>(), std::sqrt(squared)};
}

/// The circle that the most wall points are on, of all that were drawn; nullopt if half of the
/// least wall are not on it.
std::optional<Circle2> DrawCircle(const std::vector<Wall>& walls,
                                  const std::function<bool(const Circle2&)>& admissible,
                                  const FeatureOptions& options, base::Rng& rng) {
  std::optional<Circle2> best;
  std::size_t best_count = 0;
  for (int draw = 0; draw < kDrawsPerCircleDraw * options.circle.draws; ++draw) {
    const Wall& a = walls[rng.Index(walls.size())];
    const Wall& b = walls[rng.Index(walls.size())];
    const auto circle = NormalsMeet(a, b, options);
    if (!circle || circle->radius_m > options.circle.max_radius_m || !admissible(*circle)) continue;
    const std::size_t count = base::CountToBeat(
        walls, best_count, [&](const Wall& wall) { return IsOn(*circle, wall, options); });
    if (count > best_count) {
      best_count = count;
      best = circle;
    }
  }
  const auto enough = static_cast<std::size_t>(options.axis.min_wall_points / 2);
  return best_count < enough ? std::nullopt : best;
}

}  // namespace

std::vector<Wall> WallOf(const PointCloud& cloud, const Indices& points, const PlanarFrame& frame,
                         const FeatureOptions& options) {
  std::vector<Wall> wall;
  for (const auto i : points) {
    const Eigen::Vector3d& normal = cloud.normals[i];
    if (std::abs(normal.dot(frame.n)) > options.axis.max_along_axis) continue;
    wall.push_back({frame.Flat(cloud.points[i]),
                    Eigen::Vector2d(normal.dot(frame.u), normal.dot(frame.v)).normalized()});
  }
  return wall;
}

bool IsOn(const Circle2& circle, const Wall& wall, const FeatureOptions& options) {
  const Eigen::Vector2d radial = wall.p - circle.center;
  const double r = radial.norm();
  return std::abs(r - circle.radius_m) <= options.circle.distance_m &&
         wall.normal.dot(radial) > 0.0 &&
         std::abs(Cross(wall.normal, radial)) <= options.axis.max_tangential * r;
}

std::optional<Circle2> CircleAcross(const PointCloud& cloud, const Indices& points,
                                    const PlanarFrame& frame,
                                    const std::function<bool(const Circle2&)>& admissible,
                                    const FeatureOptions& options, base::Rng& rng) {
  const std::vector<Wall> walls = WallOf(cloud, points, frame, options);
  if (walls.size() < static_cast<std::size_t>(options.axis.min_wall_points)) return std::nullopt;
  auto circle = DrawCircle(walls, admissible, options, rng);
  if (!circle) return std::nullopt;
  // Two normals say little of the center; all that agree say more.
  for (int round = 0; round < kWallRefits; ++round) {
    const Circle2 refitted = Refit(walls, *circle, options);
    if (!admissible(refitted)) break;
    *circle = refitted;
  }
  return circle;
}

std::optional<RotationAxis> AxisFromBody(const PointCloud& cloud, const Indices& points,
                                         const TopSurface& top, const geometry::Plane& table,
                                         const FeatureOptions& options, base::Rng& rng) {
  const PlanarFrame frame = MakePlanarFrame(table, top.center_C);
  const auto any = [](const Circle2&) { return true; };
  const auto circle = CircleAcross(cloud, points, frame, any, options, rng);
  if (!circle) return std::nullopt;
  const Eigen::Vector3d on_table =
      top.center_C + circle->center.x() * frame.u + circle->center.y() * frame.v;
  const double height = TopHeight(cloud, points, table) - table.Distance(on_table);
  return RotationAxis{on_table + height * table.normal, table.normal, circle->radius_m, 0.0, 0.0};
}

bool IsLid(const PointCloud& cloud, const TopSurface& top, const RotationAxis& axis,
           const FeatureOptions& options) {
  const double distance_m = options.axis.lid_distance_m;
  Indices on_circle;
  std::size_t within = 0;
  for (const auto i : top.rim) {
    const double inside =
        axis.radius_m - AxisDistance(cloud.points[i], axis.center_C, axis.direction_C);
    if (inside >= -distance_m) ++within;
    if (std::abs(inside) <= distance_m) on_circle.push_back(i);
  }
  if (static_cast<double>(within) < options.axis.rim_share * static_cast<double>(top.rim.size())) {
    return false;
  }
  const Circle circle{axis.center_C, axis.direction_C, axis.radius_m};
  return ArcOf(cloud, on_circle, circle) >= options.axis.min_lid_arc_rad;
}

bool IsThinRing(const PointCloud& cloud, const TopSurface& top, const RotationAxis& axis,
                const FeatureOptions& options) {
  const auto on_lip = std::count_if(top.points.begin(), top.points.end(), [&](auto i) {
    const double inside =
        axis.radius_m - AxisDistance(cloud.points[i], axis.center_C, axis.direction_C);
    return inside >= -options.circle.distance_m && inside <= options.axis.max_wall_m;
  });
  if (static_cast<double>(on_lip) <
      options.axis.rim_share * static_cast<double>(top.points.size())) {
    return false;
  }
  const auto flat =
      Flatten(MakePlanarFrame(top.plane, top.center_C), geometry::Select(cloud.points, top.points));
  return geometry::BuildAlphaShape2(flat, options.top.rim_alpha_m).area_m2 <
         options.axis.ring_share * base::kPi * axis.radius_m * axis.radius_m;
}

}  // namespace rangegrasp::perception::internal
