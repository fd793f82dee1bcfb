#include "perception/internal/revolution.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/quantile.h"
#include "base/units.h"
#include "geometry/groups.h"
#include "geometry/hull.h"
#include "perception/internal/body_profile.h"
#include "perception/internal/circle.h"
#include "perception/internal/open_sphere.h"

namespace rangegrasp::perception::internal {
namespace {

using geometry::Points;

/// A point of a profile: depth below the rim along the axis, distance from the axis.
struct ProfilePoint {
  double depth_m;
  double radius_m;
};

/// The frame that a profile is turned in.
struct Revolution {
  Eigen::Vector3d center;
  Eigen::Vector3d direction;
  Eigen::Vector3d u;
  Eigen::Vector3d v;

  Eigen::Vector3d At(const ProfilePoint& p, double angle) const {
    return center - p.depth_m * direction +
           p.radius_m * (std::cos(angle) * u + std::sin(angle) * v);
  }
};

Revolution MakeRevolution(const RotationAxis& axis) {
  const Eigen::Vector3d u = axis.direction_C.unitOrthogonal();
  return {axis.center_C, axis.direction_C, u, axis.direction_C.cross(u)};
}

/// The outer wall from the rim to the base.
std::vector<ProfilePoint> OuterProfile(const BodyProfile& body, double radius_m, double length_m,
                                       const CompletionOptions& options) {
  const auto min_points = static_cast<std::size_t>(options.min_section_points);
  std::vector<ProfilePoint> profile{{0.0, radius_m}};
  for (const Section& s : body.sections) {
    if (s.outer_points >= min_points && s.depth_m > 0.0 && s.depth_m < length_m) {
      profile.push_back({s.depth_m, s.outer_m});
    }
  }
  profile.push_back({length_m, profile.back().radius_m});
  return profile;
}

/// How deep under the rim the floor of a cavity was seen; 0 if it was not.
double FloorDepth(const ObjectContext& context, const Part& part, double inner_m) {
  const CompletionOptions& options = context.options.completion;
  std::vector<double> depths;
  for (const auto i : part.points) {
    const Eigen::Vector3d d = context.cloud.points[i] - part.axis->center_C;
    const double depth = -d.dot(part.axis->direction_C);
    if (depth > options.min_floor_depth_m &&
        context.cloud.normals[i].dot(part.axis->direction_C) > options.min_floor_cosine &&
        AxisDistance(context.cloud.points[i], part.axis->center_C, part.axis->direction_C) <
            inner_m - options.wall_m) {
      depths.push_back(depth);
    }
  }
  if (depths.size() < static_cast<std::size_t>(options.min_floor_points)) return 0.0;
  return base::UpperMedianOf(std::move(depths));
}

/// The cavity from the axis at its floor up to the rim. Where its floor was not seen, the deepest
/// seen part of the wall stands for it: a finger goes no further than is known to be empty.
std::vector<ProfilePoint> InnerProfile(const ObjectContext& context, const Part& part,
                                       const BodyProfile& body, double length_m) {
  const CompletionOptions& options = context.options.completion;
  std::vector<ProfilePoint> wall;
  for (const Section& s : body.sections) {
    if (s.inner_points >= static_cast<std::size_t>(options.min_section_points) && s.depth_m > 0.0 &&
        s.inner_m < part.axis->radius_m) {
      wall.push_back({s.depth_m, s.inner_m});
    }
  }
  const double rim = wall.empty() ? part.axis->radius_m - options.wall_m : wall.front().radius_m;
  double floor = FloorDepth(context, part, rim);
  if (floor == 0.0) floor = wall.empty() ? part.axis->radius_m : wall.back().depth_m;
  floor = std::min(floor, length_m - options.wall_m);
  std::erase_if(wall, [&](const ProfilePoint& p) { return p.depth_m >= floor; });
  std::vector<ProfilePoint> profile{{floor, 0.0}};
  profile.push_back({floor, wall.empty() ? rim : wall.back().radius_m});
  profile.insert(profile.end(), wall.rbegin(), wall.rend());
  profile.push_back({0.0, rim});
  return profile;
}

/// The profile turned about the axis; counter-clockwise from outside for profiles that run from the
/// top's middle outward and down.
geometry::TriangleMesh Revolve(const Revolution& r, const std::vector<ProfilePoint>& profile,
                               const geometry::Plane& table, int sides) {
  geometry::TriangleMesh mesh;
  for (const ProfilePoint& p : profile) {
    for (int k = 0; k < sides; ++k) {
      Eigen::Vector3d vertex = r.At(p, 2.0 * base::kPi * k / sides);
      if (table.Distance(vertex) < 0.0) vertex = table.Project(vertex);
      mesh.vertices.push_back(vertex);
    }
  }
  const auto n = static_cast<std::uint32_t>(sides);
  for (std::uint32_t ring = 0; ring + 1 < profile.size(); ++ring) {
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t a = ring * n + k;
      const std::uint32_t b = ring * n + (k + 1) % n;
      const std::uint32_t c = a + n;
      const std::uint32_t d = b + n;
      if (profile[ring].radius_m > 0.0) mesh.triangles.push_back({a, d, b});
      if (profile[ring + 1].radius_m > 0.0) mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

/// Points further out than the body's circles.
Points Outside(const ObjectContext& context, const Part& part, const BodyProfile& body) {
  const double attached_m = context.options.completion.attached_m;
  double widest = part.axis->radius_m;
  for (const Section& s : body.sections) widest = std::max(widest, s.outer_m);
  Points outside;
  for (const auto i : part.points) {
    const auto& p = context.cloud.points[i];
    if (AxisDistance(p, part.axis->center_C, part.axis->direction_C) > widest + attached_m ||
        (p - part.axis->center_C).dot(part.axis->direction_C) > attached_m) {
      outside.push_back(p);
    }
  }
  return outside;
}

/// What is attached to the body: groups of such points that hang together, each with enough points.
std::vector<Points> Attachments(const ObjectContext& context, const Part& part,
                                const BodyProfile& body) {
  const auto min_points = static_cast<std::size_t>(context.options.completion.min_attached_points);
  auto groups =
      geometry::GroupsWithin(Outside(context, part, body), context.options.completion.link_m);
  std::erase_if(groups, [&](const Points& group) { return group.size() < min_points; });
  return groups;
}

void AddRing(const ObjectContext& context, const Revolution& r, const ProfilePoint& p,
             Points& points) {
  const double step_rad = context.options.completion.step_rad;
  const auto steps = static_cast<int>(std::lround(2.0 * base::kPi / step_rad));
  for (int k = 0; k < steps; ++k) {
    const Eigen::Vector3d q = r.At(p, k * step_rad);
    if (context.table.Distance(q) >= 0.0) points.push_back(q);
  }
}

/// Keeps a gap of exactly one step from being cut in two.
constexpr double kRounding = 1e-9;

/// The profile with points at most one section apart.
std::vector<ProfilePoint> Filled(const std::vector<ProfilePoint>& profile, double step_m) {
  std::vector<ProfilePoint> filled{profile.front()};
  for (std::size_t i = 1; i < profile.size(); ++i) {
    const ProfilePoint from = profile[i - 1];
    const double gap = profile[i].depth_m - from.depth_m;
    const auto pieces = std::max(1, static_cast<int>(std::ceil(gap / step_m - kRounding)));
    for (int k = 1; k <= pieces; ++k) {
      const double t = static_cast<double>(k) / pieces;
      filled.push_back(
          {from.depth_m + t * gap, from.radius_m + t * (profile[i].radius_m - from.radius_m)});
    }
  }
  return filled;
}

/// From the end of the axis to the other end: a lying body's, or what the body stands on.
double LengthOf(const ObjectContext& context, const RotationAxis& axis, double base_m) {
  if (axis.Lies()) return axis.length_m;
  const CompletionOptions& options = context.options.completion;
  const double upright =
      std::max(options.min_axis_cosine, axis.direction_C.dot(context.table.normal));
  return std::max(options.wall_m, (context.table.Distance(axis.center_C) - base_m) / upright);
}

}  // namespace

Completion CompleteRotational(const ObjectContext& context, const Part& part, double base_m) {
  const RotationAxis& axis = *part.axis;
  const BodyProfile body = ProfileBody(context.cloud, part.points, EndPlane(axis, *part.top),
                                       axis.center_C, axis.direction_C, context.options);
  const Revolution revolution = MakeRevolution(axis);
  const CompletionOptions& options = context.options.completion;
  const double length = LengthOf(context, axis, base_m);
  const auto outer = OuterProfile(body, axis.radius_m, length, options);

  Completion completion;
  completion.points_C = geometry::Select(context.cloud.points, part.points);
  for (const ProfilePoint& p : Filled(outer, context.options.axis.section_m)) {
    AddRing(context, revolution, p, completion.points_C);
  }
  std::vector<ProfilePoint> profile{{0.0, 0.0}};
  if (!axis.Lies() && IsOpen(context.cloud, part.points, *part.top, context.options)) {
    profile = InnerProfile(context, part, body, length);
    for (const ProfilePoint& p : profile) {
      if (p.radius_m > 0.0) AddRing(context, revolution, p, completion.points_C);
    }
  }
  profile.insert(profile.end(), outer.begin(), outer.end());
  profile.push_back({length, 0.0});
  completion.surface_C = Revolve(revolution, profile, context.table, options.sides);
  for (const Points& attachment : Attachments(context, part, body)) {
    geometry::Append(geometry::ConvexHull(attachment), completion.surface_C);
  }
  return completion;
}

}  // namespace rangegrasp::perception::internal
