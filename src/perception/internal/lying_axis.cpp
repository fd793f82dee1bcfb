#include "perception/internal/lying_axis.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/count_to_beat.h"
#include "perception/internal/axis_from_body.h"
#include "perception/internal/body_profile.h"
#include "perception/internal/ridge.h"
#include "perception/internal/top_surface.h"

namespace rangegrasp::perception::internal {
namespace {

using Eigen::Vector3d;
using geometry::Indices;
using geometry::PointCloud;

/// Rounds in which the direction is taken from the normals that the last one left square to it.
constexpr int kDirectionRounds = 3;
/// Rounds of the refit: a turn of a few degrees brings in further points with each.
constexpr int kRefits = 8;
/// Points within this many circle distances are fitted: those at the ends of a body whose direction
/// is still a few degrees off.
constexpr double kRefitBand = 2.0;
/// 1 + the normal's share upward: points that face down say nothing of a circle on the table.
constexpr double kMinRise = 0.2;

/// The direction that the normals are most nearly square to.
Vector3d SquareTo(const PointCloud& cloud, const Indices& points) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto i : points) scatter += cloud.normals[i] * cloud.normals[i].transpose();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
}

/// The points whose normals are this nearly square to the direction.
Indices Square(const PointCloud& cloud, const Indices& points, const Vector3d& direction,
               double max_along) {
  Indices square;
  for (const auto i : points) {
    if (std::abs(cloud.normals[i].dot(direction)) < max_along) square.push_back(i);
  }
  return square;
}

/// The body's direction, from its upper side first (its ends face sideways); nullopt where it is
/// too steep to lie.
std::optional<Vector3d> Direction(const PointCloud& cloud, const Indices& points,
                                  const geometry::Plane& table, const FeatureOptions& options) {
  Indices square = UpwardPoints(cloud, points, table.normal, options.ridge.window_rad);
  Vector3d direction = Vector3d::Zero();
  for (int round = 0; round < kDirectionRounds; ++round) {
    if (square.size() < static_cast<std::size_t>(options.axis.min_wall_points)) return std::nullopt;
    direction = SquareTo(cloud, square);
    square = Square(cloud, points, direction, options.ridge.max_along_axis);
  }
  if (std::abs(direction.dot(table.normal)) > options.ridge.max_axis_slope) return std::nullopt;
  Eigen::Index main = 0;  // Its sign tells the axis from its opposite.
  direction.cwiseAbs().maxCoeff(&main);
  return direction[main] < 0.0 ? Vector3d(-direction) : direction;
}

/// Across the body's direction, its normal along it, v as nearly up as that allows; the origin is
/// the points' centroid.
PlanarFrame FrameAcross(const PointCloud& cloud, const Indices& points, const Vector3d& direction,
                        const Vector3d& up) {
  const Vector3d v = (up - up.dot(direction) * direction).normalized();
  return {geometry::Centroid(geometry::Select(cloud.points, points)), v.cross(direction), v,
          direction};
}

/// The circle that touches the table and has the wall point's normal: with the point p at a height
/// h above the table, c = p - r n is r above it for r = h / (1 + n_v).
std::optional<Circle2> Touching(const Wall& wall, double table_v) {
  const double height = wall.p.y() - table_v;
  if (height <= 0.0 || 1.0 + wall.normal.y() < kMinRise) return std::nullopt;
  const double radius = height / (1.0 + wall.normal.y());
  return Circle2{wall.p - radius * wall.normal, radius};
}

/// The circle on the table that the most wall points are on; a body that lies rests on it, which
/// says more than the arc seen from above. nullopt if too few are on any.
std::optional<Circle2> CircleOnTable(const std::vector<Wall>& walls, double table_v,
                                     const FeatureOptions& options, base::Rng& rng) {
  if (walls.size() < static_cast<std::size_t>(options.axis.min_wall_points)) return std::nullopt;
  std::optional<Circle2> best;
  std::size_t best_count = 0;
  for (int draw = 0; draw < options.circle.draws; ++draw) {
    const auto circle = Touching(walls[rng.Index(walls.size())], table_v);
    if (!circle || circle->radius_m > options.circle.max_radius_m) continue;
    const std::size_t count = base::CountToBeat(
        walls, best_count, [&](const Wall& wall) { return IsOn(*circle, wall, options); });
    if (count > best_count) {
      best_count = count;
      best = circle;
    }
  }
  if (!best || best_count < static_cast<std::size_t>(options.axis.min_wall_points / 2)) {
    return std::nullopt;
  }
  return best;
}

/// A cylinder that lies on the table: the frame across it, whose origin is on its axis.
struct Lying {
  PlanarFrame frame;
  double radius_m;
};

/// One step of Gauss-Newton over the wall points that are on the cylinder: with e the direction
/// from the axis to a point that is s along it, the distance from the surface changes by e_u, s
/// e_u, s e_v and e_v + 1 for a shift along u, a turn, a slope, and a radius that lifts the axis
/// with it.
Lying Refitted(const PointCloud& cloud, const Indices& points, const Lying& body,
               const FeatureOptions& options) {
  Eigen::Matrix4d left = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  const PlanarFrame& frame = body.frame;
  for (const auto i : points) {
    const Eigen::Vector2d q = frame.Flat(cloud.points[i]);
    const double off = q.norm() - body.radius_m;
    if (std::abs(off) > kRefitBand * options.circle.distance_m) continue;
    const Eigen::Vector2d e = q.normalized();
    const Vector3d out = e.x() * frame.u + e.y() * frame.v;
    if (cloud.normals[i].dot(out) < options.axis.max_along_axis) continue;
    const double s = (cloud.points[i] - frame.origin).dot(frame.n);
    const Eigen::Vector4d g(e.x(), s * e.x(), s * e.y(), 1.0 + e.y());
    left += g * g.transpose();
    right += off * g;
  }
  const Eigen::Vector4d step = left.ldlt().solve(right);
  if (!step.allFinite() || body.radius_m + step[3] <= 0.0) return body;
  Lying refitted = body;
  refitted.radius_m += step[3];
  refitted.frame.origin += step[0] * frame.u + step[3] * frame.v;
  refitted.frame.n = (frame.n + step[1] * frame.u + step[2] * frame.v).normalized();
  refitted.frame.v = (frame.v - frame.v.dot(refitted.frame.n) * refitted.frame.n).normalized();
  refitted.frame.u = refitted.frame.v.cross(refitted.frame.n);
  return refitted;
}

/// The axis of such a body, from end to end.
RotationAxis AxisOf(const Lying& body, const PointCloud& cloud, const Indices& points) {
  const geometry::Plane across{body.frame.n, 0.0};
  const double high = TopHeight(cloud, points, across);
  RotationAxis axis{body.frame.origin, body.frame.n, body.radius_m};
  axis.length_m = high - BaseHeight(cloud, points, across);
  axis.center_C += (high - across.Distance(axis.center_C)) * body.frame.n;
  return axis;
}

/// The second rule, with its normals; the body has to be seen far enough round, too.
bool Agrees(const PointCloud& cloud, const Indices& points, const FeatureOptions& options,
            RotationAxis& axis) {
  if (!axis.Lies()) return false;
  const geometry::Plane end{axis.direction_C, -axis.direction_C.dot(axis.center_C)};
  const BodyProfile body =
      ProfileBody(cloud, points, end, axis.center_C, axis.direction_C, options);
  axis.body_fraction = body.fraction;
  const Circle circle{axis.center_C, axis.direction_C, axis.radius_m};
  return body.fraction >= options.axis.lying_body_share &&
         body.normal_fraction >= options.axis.normal_share &&
         ArcOf(cloud, body.agreeing, circle) >= options.axis.min_lying_arc_rad;
}

}  // namespace

std::optional<RotationAxis> FindLyingAxis(const PointCloud& cloud, const Indices& points,
                                          const geometry::Plane& table,
                                          const FeatureOptions& options, base::Rng& rng) {
  const auto direction = Direction(cloud, points, table, options);
  if (!direction) return std::nullopt;
  const PlanarFrame frame = FrameAcross(cloud, points, *direction, table.normal);
  const auto on_table = CircleOnTable(WallOf(cloud, points, frame, options),
                                      -table.Distance(frame.origin), options, rng);
  const auto about = [&](const Circle2& circle) {
    PlanarFrame about_axis = frame;
    about_axis.origin = frame.Lift(circle.center);
    return Lying{about_axis, circle.radius_m};
  };
  if (on_table) {
    Lying body = about(*on_table);
    for (int round = 0; round < kRefits; ++round) body = Refitted(cloud, points, body, options);
    RotationAxis axis = AxisOf(body, cloud, points);
    if (Agrees(cloud, points, options, axis)) return axis;
  }
  // On something else than the table. A flatter arc that would reach under it fits as well.
  const auto above_table = [&](const Circle2& circle) {
    return table.Distance(frame.Lift(circle.center)) >= circle.radius_m - options.axis.max_sunk_m;
  };
  const auto above = CircleAcross(cloud, points, frame, above_table, options, rng);
  if (!above) return std::nullopt;
  RotationAxis axis = AxisOf(about(*above), cloud, points);
  return Agrees(cloud, points, options, axis) ? std::optional(axis) : std::nullopt;
}

}  // namespace rangegrasp::perception::internal
