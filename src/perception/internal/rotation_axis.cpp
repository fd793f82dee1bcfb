#include "perception/internal/rotation_axis.h"

#include <Eigen/Geometry>
#include <functional>
#include <map>

#include "base/linear_algebra.h"
#include "geometry/alpha_shape.h"
#include "perception/internal/body_profile.h"
#include "perception/internal/top_surface.h"

namespace rangegrasp::perception::internal {
namespace {

/// A draw of two points with normals fails more often than one of three rim points.
constexpr int kDrawsPerCircleDraw = 2;
/// Number of refits of the circle: the points that agree change a little with each.
constexpr int kWallRefits = 5;

/// A point of a body seen along an axis: its position and the direction of its normal.
struct Wall {
  Vector2d p;
  Vector2d normal;  ///< unit
};

/// The part of the wall that was seen about the frame's normal, in the frame.
std::vector<Wall> WallOf(const ObjectContext& context, const Indices& points,
                         const PlanarFrame& frame) {
  std::vector<Wall> wall;
  for (const auto i : points) {
    const Vector3d& normal = context.cloud.normals[i];
    if (std::abs(normal.dot(frame.n)) > context.options.axis.max_along_axis) continue;
    wall.push_back({frame.Flat(context.cloud.points[i]),
                    Vector2d(normal.dot(frame.u), normal.dot(frame.v)).normalized()});
  }
  return wall;
}

/// Whether a point faces away from the center and is on the circle about it.
bool IsOn(const Circle2& circle, const Wall& wall, const FeatureOptions& options) {
  const Vector2d radial = wall.p - circle.center;
  const double r = radial.norm();
  return std::abs(r - circle.radius_m) <= options.circle.distance_m &&
         wall.normal.dot(radial) > 0.0 &&
         std::abs(Cross(wall.normal, radial)) <= options.axis.max_tangential * r;
}

Circle CircleOf(const RotationAxis& axis) {
  return {axis.center_C, axis.direction_C, axis.radius_m};
}

/// How far a point is inside the axis' circle [m].
double Inside(const PointCloud& cloud, std::uint32_t i, const RotationAxis& axis) {
  return axis.radius_m - AxisDistance(cloud.points[i], axis.center_C, axis.direction_C);
}

/// The circle about the point where two wall points' normals meet, if both are as far from it.
std::optional<Circle2> NormalsMeet(const Wall& a, const Wall& b, const FeatureOptions& options) {
  Eigen::Matrix2d directions;
  directions << -a.normal, b.normal;
  if (std::abs(directions.determinant()) < options.axis.min_normals_sine) return std::nullopt;
  const Vector2d steps = directions.inverse() * (b.p - a.p);
  // p - step * normal: the center lies behind both, at the same distance except for their noise.
  if (steps.minCoeff() <= 0.0 || std::abs(steps[0] - steps[1]) > 2.0 * options.circle.distance_m) {
    return std::nullopt;
  }
  const Vector2d center = 0.5 * (a.p - steps[0] * a.normal + b.p - steps[1] * b.normal);
  return Circle2{center, 0.5 * ((a.p - center).norm() + (b.p - center).norm())};
}

/// The least-squares circle (Kasa 1976: linear in center and r^2 - |center|^2) through the wall
/// points that agree.
Circle2 Refit(const std::vector<Wall>& walls, const Circle2& circle,
              const FeatureOptions& options) {
  Matrix3d left = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const Wall& wall : walls) {
    if (!IsOn(circle, wall, options)) continue;
    const Vector2d d = wall.p - circle.center;
    const Vector3d row(2.0 * d.x(), 2.0 * d.y(), 1.0);
    left += row * row.transpose();
    right += d.squaredNorm() * row;
  }
  const Vector3d solved = base::SolveLdlt(left, right);
  const double squared = solved[2] + solved.head<2>().squaredNorm();
  if (!solved.allFinite() || squared <= 0.0) return circle;
  return {circle.center + solved.head<2>(), std::sqrt(squared)};
}

/// The drawn circle with most wall points on it; nullopt if they are below half of the minimum.
std::optional<Circle2> DrawCircle(int draws, const std::vector<Wall>& walls,
                                  const std::function<std::optional<Circle2>()>& candidate,
                                  const FeatureOptions& options) {
  if (walls.size() < static_cast<std::size_t>(options.axis.min_wall_points)) return std::nullopt;
  const auto draw = [&] {
    const auto circle = candidate();
    return circle && circle->radius_m <= options.circle.max_radius_m ? circle : std::nullopt;
  };
  const auto is_on = [&](const Circle2& c, const Wall& wall) { return IsOn(c, wall, options); };
  const auto [best, count] = BestOfDraws(draws, draw, walls, is_on);
  const auto enough = static_cast<std::size_t>(options.axis.min_wall_points / 2);
  return count < enough ? std::nullopt : best;
}

/// The circle of a body seen along the frame's normal: two wall points with their normals give a
/// center (as in eq. 4.18 to 4.21, with normals instead of a third point); the circle with which
/// most agree (eq. 5.7) is refitted to them.
/// @return nullopt if the wall has too few points, or too few that agree.
std::optional<Circle2> CircleAcross(const ObjectContext& context, const Indices& points,
                                    const PlanarFrame& frame,
                                    const std::function<bool(const Circle2&)>& admissible,
                                    base::Rng& rng) {
  const FeatureOptions& options = context.options;
  const std::vector<Wall> walls = WallOf(context, points, frame);
  const auto draw = [&] {
    const Wall& a = walls[rng.Index(walls.size())];
    const Wall& b = walls[rng.Index(walls.size())];
    const auto circle = NormalsMeet(a, b, options);
    return circle && admissible(*circle) ? circle : std::nullopt;
  };
  auto circle = DrawCircle(kDrawsPerCircleDraw * options.circle.draws, walls, draw, options);
  if (!circle) return std::nullopt;
  // Two normals locate the center poorly; all that agree locate it better.
  for (int round = 0; round < kWallRefits; ++round) {
    const Circle2 refitted = Refit(walls, *circle, options);
    if (!admissible(refitted)) break;
    *circle = refitted;
  }
  return circle;
}

/// Rounds in which the direction is fitted to the normals that the last one left normal to it.
constexpr int kDirectionRounds = 3;
/// Rounds of the refit: each turn of a few degrees brings in further points.
constexpr int kRefits = 8;
/// Points within this many circle distances are fitted, to include those at the ends of a body
/// whose direction is still a few degrees off.
constexpr double kRefitBand = 2.0;
/// 1 + the normal's upward part: points that face down do not determine a circle on the table.
constexpr double kMinRise = 0.2;

Vector3d SquareTo(const PointCloud& cloud, const Indices& points) {
  Matrix3d scatter = Matrix3d::Zero();
  for (const auto i : points) scatter += cloud.normals[i] * cloud.normals[i].transpose();
  return base::SymmetricEigen(scatter).vectors.col(0);
}

/// First from the body's upper side (its ends face sideways); nullopt if it is too steep to lie.
std::optional<Vector3d> Direction(const ObjectContext& context, const Indices& points) {
  const auto& [cloud, table, views, options] = context;
  Indices square = UpwardPoints(cloud, points, table.normal, options.ridge.window_rad);
  Vector3d direction = Vector3d::Zero();
  for (int round = 0; round < kDirectionRounds; ++round) {
    if (square.size() < static_cast<std::size_t>(options.axis.min_wall_points)) return std::nullopt;
    direction = SquareTo(cloud, square);
    square = Where(points, [&](auto i) {
      return std::abs(cloud.normals[i].dot(direction)) < options.ridge.max_along_axis;
    });
  }
  if (std::abs(direction.dot(table.normal)) > options.ridge.max_axis_slope) return std::nullopt;
  return WithoutSign(direction);
}

/// The frame normal to the body's direction, v as nearly up as possible, at the points' centroid.
PlanarFrame FrameAcross(const PointCloud& cloud, const Indices& points, const Vector3d& direction,
                        const Vector3d& up) {
  const Vector3d v = (up - up.dot(direction) * direction).normalized();
  return {geometry::Centroid(Select(cloud.points, points)), v.cross(direction), v, direction};
}

/// The circle that touches the table and has the wall point's normal: with the point p at a height
/// h above the table, c = p - r n is r above it for r = h / (1 + n_v).
std::optional<Circle2> Touching(const Wall& wall, double table_v) {
  const double height = wall.p.y() - table_v;
  if (height <= 0.0 || 1.0 + wall.normal.y() < kMinRise) return std::nullopt;
  const double radius = height / (1.0 + wall.normal.y());
  return Circle2{wall.p - radius * wall.normal, radius};
}

/// A lying body rests on the table, which says more than the arc seen from above.
std::optional<Circle2> CircleOnTable(const std::vector<Wall>& walls, double table_v,
                                     const FeatureOptions& options, base::Rng& rng) {
  const auto draw = [&] { return Touching(walls[rng.Index(walls.size())], table_v); };
  return DrawCircle(options.circle.draws, walls, draw, options);
}

/// A cylinder that lies on the table: the frame across it, with its origin on the axis.
struct Lying {
  PlanarFrame frame;
  double radius_m;
};

/// One step of Gauss-Newton over the wall points on the cylinder: with e the direction from the
/// axis to a point that is s along it, the distance from the surface changes by e_u, s e_u, s e_v
/// and e_v + 1 for a shift along u, a turn, a slope, and a radius that lifts the axis with it.
Lying Refitted(const ObjectContext& context, const Indices& points, const Lying& body) {
  const auto& [cloud, table, views, options] = context;
  Eigen::Matrix4d left = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  const PlanarFrame& frame = body.frame;
  for (const auto i : points) {
    const Vector2d q = frame.Flat(cloud.points[i]);
    const double off = q.norm() - body.radius_m;
    if (std::abs(off) > kRefitBand * options.circle.distance_m) continue;
    const Vector2d e = q.normalized();
    const Vector3d out = e.x() * frame.u + e.y() * frame.v;
    if (cloud.normals[i].dot(out) < options.axis.max_along_axis) continue;
    const double s = frame.Height(cloud.points[i]);
    const Eigen::Vector4d g(e.x(), s * e.x(), s * e.y(), 1.0 + e.y());
    left += g * g.transpose();
    right += off * g;
  }
  const Eigen::Vector4d step = base::SolveLdlt(left, right);
  if (!step.allFinite() || body.radius_m + step[3] <= 0.0) return body;
  Lying refitted = body;
  refitted.radius_m += step[3];
  refitted.frame.origin += step[0] * frame.u + step[3] * frame.v;
  refitted.frame.n = (frame.n + step[1] * frame.u + step[2] * frame.v).normalized();
  refitted.frame.v = (frame.v - frame.v.dot(refitted.frame.n) * refitted.frame.n).normalized();
  refitted.frame.u = refitted.frame.v.cross(refitted.frame.n);
  return refitted;
}

RotationAxis AxisOf(const Lying& body, const PointCloud& cloud, const Indices& points) {
  const Plane across{body.frame.n, 0.0};
  const double high = TopHeight(cloud, points, across);
  RotationAxis axis{body.frame.origin, body.frame.n, body.radius_m};
  axis.length_m = high - BaseHeight(cloud, points, across);
  axis.center_C += (high - across.Distance(axis.center_C)) * body.frame.n;
  return axis;
}

/// The second rule, with its normals; the body must also be seen over a large enough arc.
bool Agrees(const ObjectContext& context, const Indices& points, RotationAxis& axis) {
  if (!axis.Lies()) return false;
  const AxisOptions& options = context.options.axis;
  const Plane end = geometry::PlaneAt(axis.direction_C, axis.center_C);
  const auto body = ProfileBody(context, points, end, axis);
  axis.body_fraction = body.fraction;
  return body.fraction >= options.lying_body_share &&
         body.normal_fraction >= options.normal_share &&
         ArcOf(context.cloud, body.agreeing, CircleOf(axis)) >= options.min_lying_arc_rad;
}

/// The first rule.
std::optional<RotationAxis> AxisFromRim(const ObjectContext& context, const Indices& rim,
                                        const TopSurface& top, double min_arc_rad, base::Rng& rng) {
  const auto& [cloud, table, views, options] = context;
  const auto fit = FitCircle(Select(cloud.points, rim), options.circle, rng);
  if (!fit) return std::nullopt;
  const double share = static_cast<double>(fit->inliers.size()) / static_cast<double>(rim.size());
  if (share < options.axis.rim_share) return std::nullopt;
  Indices on_circle;
  for (const auto k : fit->inliers) on_circle.push_back(rim[k]);
  if (options.arc_rule && ArcOf(cloud, on_circle, fit->circle) < min_arc_rad) return std::nullopt;
  return RotationAxis{fit->circle.center, top.plane.normal, fit->circle.radius_m, share, 0.0};
}

/// Profiles the body about the axis and about the vertical; the better one becomes the axis.
BodyProfile BodyOf(const ObjectContext& context, const Indices& points, const TopSurface& top,
                   RotationAxis& axis) {
  const auto& [cloud, table, views, options] = context;
  auto body = ProfileBody(context, points, top.plane, axis);
  if (options.upright_axes &&
      axis.direction_C.dot(table.normal) > std::cos(options.axis.upright_rad)) {
    RotationAxis upright = axis;
    upright.direction_C = table.normal;
    auto about_upright = ProfileBody(context, points, top.plane, upright);
    if (about_upright.fraction >= body.fraction) {
      axis = upright;
      body = std::move(about_upright);
    }
  }
  axis.body_fraction = body.fraction;
  return body;
}

/// The mean over points of their section's arc: a round cap does not make a flat bottle round.
double MeanArc(const ObjectContext& context, const BodyProfile& body, const RotationAxis& axis) {
  const PointCloud& cloud = context.cloud;
  std::map<int, Indices> sections;
  const Indices on_circle = OnCircle(body);
  for (const auto i : on_circle) {
    const double depth = (axis.center_C - cloud.points[i]).dot(axis.direction_C);
    sections[SectionOf(depth, context.options)].push_back(i);
  }
  double sum = 0.0;
  for (const auto& [section, points] : sections) {
    sum += static_cast<double>(points.size()) * ArcOf(cloud, points, CircleOf(axis));
  }
  return sum / static_cast<double>(std::max<std::size_t>(1, on_circle.size()));
}

/// The second rule and the test of the normals, and whether the points on the circles go this far
/// around the axis; a lid alone cannot show that. May turn the axis (BodyOf).
bool BodyAgrees(const ObjectContext& context, const Indices& points, const TopSurface& top,
                double min_share, double min_arc_rad, RotationAxis& axis) {
  const FeatureOptions& options = context.options;
  const BodyProfile body = BodyOf(context, points, top, axis);
  if (body.fraction < min_share ||
      (options.radial_normals && body.normal_fraction < options.axis.normal_share)) {
    return false;
  }
  const auto seen = body.agreeing.size() + body.turned.size();
  return !options.arc_rule || seen < static_cast<std::size_t>(options.axis.min_body_points) ||
         MeanArc(context, body, axis) >= min_arc_rad;
}

/// Whether the top is a lid: its rim is within the circle, and covers a large enough arc of it.
bool IsLid(const ObjectContext& context, const TopSurface& top, const RotationAxis& axis) {
  const PointCloud& cloud = context.cloud;
  const AxisOptions& options = context.options.axis;
  const auto within = [&](auto i) { return Inside(cloud, i, axis) >= -options.lid_distance_m; };
  if (!HoldsForShare(options.rim_share, top.rim, within)) return false;
  const Indices on_circle = Where(
      top.rim, [&](auto i) { return std::abs(Inside(cloud, i, axis)) <= options.lid_distance_m; });
  return ArcOf(cloud, on_circle, CircleOf(axis)) >= options.min_lid_arc_rad;
}

/// The axis of a body whose rim gives no circle: its lip is too thin, or its lid has holes.
std::optional<RotationAxis> AxisOfWall(const ObjectContext& context, const Indices& points,
                                       const TopSurface& top, base::Rng& rng) {
  auto axis = AxisFromBody(context, points, top, rng);
  if (!axis) return std::nullopt;
  const bool ring = IsThinRing(context, top, *axis);
  if (!ring && !IsLid(context, top, *axis)) return std::nullopt;
  const AxisOptions& options = context.options.axis;
  const double min_share = ring ? options.ring_body_share : options.body_share;
  const double min_arc_rad = ring ? options.min_ring_arc_rad : options.min_body_arc_rad;
  return BodyAgrees(context, points, top, min_share, min_arc_rad, *axis) ? axis : std::nullopt;
}

}  // namespace

std::optional<RotationAxis> FindStandingAxis(const ObjectContext& context, const Indices& points,
                                             const TopSurface& top, base::Rng& rng) {
  const FeatureOptions& options = context.options;
  for (const bool bridged : {false, true}) {
    if (top.ridge || (bridged && !options.bridged_rims)) break;
    const Indices& rim = bridged ? top.bridged_rim : top.rim;
    const double min_arc = bridged ? options.axis.min_bridged_arc_rad : options.axis.min_arc_rad;
    auto axis = AxisFromRim(context, rim, top, min_arc, rng);
    if (!axis) continue;
    if (BodyAgrees(context, points, top, options.axis.body_share, options.axis.min_body_arc_rad,
                   *axis)) {
      return axis;
    }
  }
  if (!options.axis_from_body) return std::nullopt;
  return AxisOfWall(context, points, top, rng);
}

std::optional<RotationAxis> AxisFromBody(const ObjectContext& context, const Indices& points,
                                         const TopSurface& top, base::Rng& rng) {
  const Plane& table = context.table;
  const PlanarFrame frame = MakePlanarFrame(table, top.center_C);
  const auto any = [](const Circle2&) { return true; };
  const auto circle = CircleAcross(context, points, frame, any, rng);
  if (!circle) return std::nullopt;
  const Vector2d& q = circle->center;
  const Vector3d on_table = top.center_C + q.x() * frame.u + q.y() * frame.v;
  const double height = TopHeight(context.cloud, points, table) - table.Distance(on_table);
  return RotationAxis{on_table + height * table.normal, table.normal, circle->radius_m, 0.0, 0.0};
}

bool IsOnLip(const ObjectContext& context, const Indices& points, const RotationAxis& axis) {
  const FeatureOptions& options = context.options;
  return HoldsForShare(options.axis.rim_share, points, [&](auto i) {
    const double inside = Inside(context.cloud, i, axis);
    return inside >= -options.circle.distance_m && inside <= options.axis.max_wall_m;
  });
}

bool IsThinRing(const ObjectContext& context, const TopSurface& top, const RotationAxis& axis) {
  if (!IsOnLip(context, top.points, axis)) return false;
  const FeatureOptions& options = context.options;
  const auto flat =
      Flatten(MakePlanarFrame(top.plane, top.center_C), Select(context.cloud.points, top.points));
  return geometry::BuildAlphaShape2(flat, options.top.rim_alpha_m).area_m2 <
         options.axis.ring_share * base::kPi * axis.radius_m * axis.radius_m;
}

std::optional<RotationAxis> FindLyingAxis(const ObjectContext& context, const Indices& points,
                                          base::Rng& rng) {
  const auto& [cloud, table, views, options] = context;
  const auto direction = Direction(context, points);
  if (!direction) return std::nullopt;
  const PlanarFrame frame = FrameAcross(cloud, points, *direction, table.normal);
  const auto on_table =
      CircleOnTable(WallOf(context, points, frame), -table.Distance(frame.origin), options, rng);
  const auto about = [&](const Circle2& circle) {
    PlanarFrame about_axis = frame;
    about_axis.origin = frame.Lift(circle.center);
    return Lying{about_axis, circle.radius_m};
  };
  if (on_table) {
    Lying body = about(*on_table);
    for (int round = 0; round < kRefits; ++round) body = Refitted(context, points, body);
    RotationAxis axis = AxisOf(body, cloud, points);
    if (Agrees(context, points, axis)) return axis;
  }
  // The body lies on something else than the table. A flatter arc that reaches under it also fits.
  const auto above_table = [&](const Circle2& circle) {
    return table.Distance(frame.Lift(circle.center)) >= circle.radius_m - options.axis.max_sunk_m;
  };
  const auto above = CircleAcross(context, points, frame, above_table, rng);
  if (!above) return std::nullopt;
  RotationAxis axis = AxisOf(about(*above), cloud, points);
  return Agrees(context, points, axis) ? std::optional(axis) : std::nullopt;
}

double ShareOnCircle(const PointCloud& cloud, const Indices& points, const Circle& circle,
                     double distance_m) {
  if (points.empty()) return 0.0;
  const auto on = std::ranges::count_if(
      points, [&](auto i) { return CircleDistance(circle, cloud.points[i]) <= distance_m; });
  return static_cast<double>(on) / static_cast<double>(points.size());
}

std::optional<RotationAxis> FindRotationAxis(const ObjectContext& context, const Indices& points,
                                             const TopSurface& top, base::Rng& rng) {
  const auto axis = FindStandingAxis(context, points, top, rng);
  return axis || !context.options.lying_axes ? axis : FindLyingAxis(context, points, rng);
}

}  // namespace rangegrasp::perception::internal
