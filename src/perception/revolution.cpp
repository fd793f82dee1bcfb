// Completion of rotational parts: profiles, rings and surfaces of revolution.
#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "geometry/hull.h"
#include "geometry/kd_tree.h"
#include "perception/completion.h"
#include "perception/features.h"
#include "perception/planar.h"

namespace rangegrasp::perception {
namespace {

using geometry::Indices;
using geometry::Points;

constexpr int kSides = 36;
// A wall that was not seen from inside, and a floor under it.
constexpr double kWall_m = 0.004;
// Sections with fewer points are taken from their neighbours.
constexpr std::size_t kLeastSectionPoints = 3;

/// A point of a profile: depth below the rim along the axis, distance from the axis.
struct ProfilePoint {
  double depth_m;
  double radius_m;
};

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
std::vector<ProfilePoint> OuterProfile(const BodyProfile& body, double radius_m, double length_m) {
  std::vector<ProfilePoint> profile{{0.0, radius_m}};
  for (const Section& s : body.sections) {
    if (s.outer_points >= kLeastSectionPoints && s.depth_m > 0.0 && s.depth_m < length_m) {
      profile.push_back({s.depth_m, s.outer_m});
    }
  }
  profile.push_back({length_m, profile.back().radius_m});
  return profile;
}

double FloorDepth(const CompletionContext& context, const Part& part, double inner_m) {
  std::vector<double> depths;
  for (const auto i : part.points) {
    const Eigen::Vector3d d = context.cloud.points[i] - part.axis->center_C;
    const double depth = -d.dot(part.axis->direction_C);
    if (depth > 0.010 && context.cloud.normals[i].dot(part.axis->direction_C) > 0.8 &&
        AxisDistance(context.cloud.points[i], part.axis->center_C, part.axis->direction_C) <
            inner_m - kWall_m) {
      depths.push_back(depth);
    }
  }
  if (depths.size() < 10) return 0.0;
  std::nth_element(depths.begin(), depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2),
                   depths.end());
  return depths[depths.size() / 2];
}

/// The cavity from the axis at its floor up to the rim. Where its floor was not seen, the deepest
/// seen part of the wall stands for it: a finger goes no further than is known to be empty.
std::vector<ProfilePoint> InnerProfile(const CompletionContext& context, const Part& part,
                                       const BodyProfile& body, double length_m) {
  std::vector<ProfilePoint> wall;
  for (const Section& s : body.sections) {
    if (s.inner_points >= kLeastSectionPoints && s.depth_m > 0.0 &&
        s.inner_m < part.axis->radius_m) {
      wall.push_back({s.depth_m, s.inner_m});
    }
  }
  const double rim = wall.empty() ? part.axis->radius_m - kWall_m : wall.front().radius_m;
  double floor = FloorDepth(context, part, rim);
  if (floor == 0.0) floor = wall.empty() ? part.axis->radius_m : wall.back().depth_m;
  floor = std::min(floor, length_m - kWall_m);
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
                               const geometry::Plane& table) {
  geometry::TriangleMesh mesh;
  for (const ProfilePoint& p : profile) {
    for (int k = 0; k < kSides; ++k) {
      Eigen::Vector3d vertex = r.At(p, 2.0 * core::kPi * k / kSides);
      if (table.Distance(vertex) < 0.0) vertex = table.Project(vertex);
      mesh.vertices.push_back(vertex);
    }
  }
  for (std::uint32_t ring = 0; ring + 1 < profile.size(); ++ring) {
    for (std::uint32_t k = 0; k < kSides; ++k) {
      const std::uint32_t a = ring * kSides + k;
      const std::uint32_t b = ring * kSides + (k + 1) % kSides;
      const std::uint32_t c = a + kSides;
      const std::uint32_t d = b + kSides;
      if (profile[ring].radius_m > 0.0) mesh.triangles.push_back({a, d, b});
      if (profile[ring + 1].radius_m > 0.0) mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

/// Points further out than the body's circles, in groups that hang together.
std::vector<Points> Attachments(const CompletionContext& context, const Part& part,
                                const BodyProfile& body) {
  constexpr double kLeastOut_m = 0.003;
  constexpr double kLink_m = 0.006;
  constexpr std::size_t kLeastPoints = 15;
  double widest = part.axis->radius_m;
  for (const Section& s : body.sections) widest = std::max(widest, s.outer_m);
  Points outside;
  for (const auto i : part.points) {
    const auto& p = context.cloud.points[i];
    if (AxisDistance(p, part.axis->center_C, part.axis->direction_C) > widest + kLeastOut_m ||
        (p - part.axis->center_C).dot(part.axis->direction_C) > kLeastOut_m) {
      outside.push_back(p);
    }
  }
  std::vector<Points> groups;
  if (outside.size() < kLeastPoints) return groups;
  const geometry::KdTree tree(outside);
  std::vector<bool> taken(outside.size(), false);
  std::vector<geometry::KdTree::Neighbor> near;
  for (std::uint32_t seed = 0; seed < outside.size(); ++seed) {
    if (taken[seed]) continue;
    std::vector<std::uint32_t> group{seed};
    taken[seed] = true;
    for (std::size_t next = 0; next < group.size(); ++next) {
      tree.Within(outside[group[next]], kLink_m, near);
      for (const auto& neighbor : near) {
        if (taken[neighbor.index]) continue;
        taken[neighbor.index] = true;
        group.push_back(neighbor.index);
      }
    }
    if (group.size() < kLeastPoints) continue;
    std::sort(group.begin(), group.end());
    groups.push_back(geometry::Select(outside, group));
  }
  return groups;
}

void AddRing(const CompletionContext& context, const Revolution& r, const ProfilePoint& p,
             Points& points) {
  const auto steps =
      static_cast<int>(std::lround(2.0 * core::kPi / context.options.completion_step_rad));
  for (int k = 0; k < steps; ++k) {
    const Eigen::Vector3d q = r.At(p, k * context.options.completion_step_rad);
    if (context.table.Distance(q) >= 0.0) points.push_back(q);
  }
}

/// The profile with points at most one section apart.
std::vector<ProfilePoint> Filled(const std::vector<ProfilePoint>& profile, double step_m) {
  std::vector<ProfilePoint> filled{profile.front()};
  for (std::size_t i = 1; i < profile.size(); ++i) {
    const ProfilePoint from = profile[i - 1];
    const double gap = profile[i].depth_m - from.depth_m;
    const auto pieces = std::max(1, static_cast<int>(std::ceil(gap / step_m - 1e-9)));
    for (int k = 1; k <= pieces; ++k) {
      const double t = static_cast<double>(k) / pieces;
      filled.push_back(
          {from.depth_m + t * gap, from.radius_m + t * (profile[i].radius_m - from.radius_m)});
    }
  }
  return filled;
}

}  // namespace

Completion CompleteRotational(const CompletionContext& context, const Part& part, double base_m) {
  const RotationAxis& axis = *part.axis;
  const BodyProfile body = ProfileBody(context.cloud, part.points, *part.top, axis.center_C,
                                       axis.direction_C, context.options);
  const Revolution revolution = MakeRevolution(axis);
  const double upright = std::max(0.3, axis.direction_C.dot(context.table.normal));
  const double length =
      std::max(kWall_m, (context.table.Distance(axis.center_C) - base_m) / upright);
  const auto outer = OuterProfile(body, axis.radius_m, length);

  Completion completion;
  completion.points_C = geometry::Select(context.cloud.points, part.points);
  for (const ProfilePoint& p : Filled(outer, context.options.section_m)) {
    AddRing(context, revolution, p, completion.points_C);
  }
  std::vector<ProfilePoint> profile{{0.0, 0.0}};
  if (IsOpen(context.cloud, part.points, *part.top, context.options)) {
    profile = InnerProfile(context, part, body, length);
    for (const ProfilePoint& p : profile) {
      if (p.radius_m > 0.0) AddRing(context, revolution, p, completion.points_C);
    }
  }
  profile.insert(profile.end(), outer.begin(), outer.end());
  profile.push_back({length, 0.0});
  completion.surface_C = Revolve(revolution, profile, context.table);
  for (const Points& attachment : Attachments(context, part, body)) {
    geometry::Append(geometry::ConvexHull(attachment), completion.surface_C);
  }
  return completion;
}

}  // namespace rangegrasp::perception
