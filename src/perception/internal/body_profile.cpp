#include "perception/internal/body_profile.h"

#include <Eigen/Geometry>
#include <iterator>
#include <map>

#include "base/linear_algebra.h"

namespace rangegrasp::perception::internal {
namespace {

struct Member {
  double distance_m;
  std::uint32_t point;
  bool normal_passes_axis;
};

/// The points of each section, those that face outward before those that face the axis.
using Members = std::map<std::pair<int, bool>, std::vector<Member>>;

/// The radius about which most members lie, and the range of these among the sorted members.
struct Agreement {
  double radius_m = 0.0;
  std::size_t first = 0;
  std::size_t last = 0;  ///< one past the end
};

Agreement Agree(std::vector<Member>& members, double distance_m) {
  std::ranges::sort(members, {}, [](const Member& m) { return std::pair(m.distance_m, m.point); });
  Agreement best;
  std::size_t last = 0;
  for (std::size_t first = 0; first < members.size(); ++first) {
    while (last < members.size() &&
           members[last].distance_m <= members[first].distance_m + 2.0 * distance_m) {
      ++last;
    }
    if (last - first > best.last - best.first) best = {0.0, first, last};
  }
  for (std::size_t i = best.first; i < best.last; ++i) best.radius_m += members[i].distance_m;
  best.radius_m /= static_cast<double>(std::max<std::size_t>(1, best.last - best.first));
  return best;
}

Members BySection(const ObjectContext& context, const Indices& points, const Plane& top,
                  const RotationAxis& axis) {
  const auto& [cloud, table, views, options] = context;
  const Vector3d& direction_C = axis.direction_C;
  Members sections;
  for (const auto i : points) {
    const Vector3d& normal = cloud.normals[i];
    if (std::abs(top.Distance(cloud.points[i])) <= options.top.plane_distance_m ||
        std::abs(normal.dot(direction_C)) > options.axis.max_along_axis) {
      continue;
    }
    const Vector3d d = cloud.points[i] - axis.center_C;
    const double depth = -d.dot(direction_C);
    const Vector3d radial = d + depth * direction_C;
    const bool passes_axis =
        !options.radial_normals || std::abs(normal.dot(direction_C.cross(radial))) <=
                                       options.axis.max_tangential * radial.norm();
    sections[{SectionOf(depth, options), normal.dot(radial) < 0.0}].push_back(
        {AxisDistance(cloud.points[i], axis.center_C, direction_C), i, passes_axis});
  }
  return sections;
}

void AddMembers(const std::vector<Member>& members, const Agreement& agreement, bool inward,
                BodyProfile& profile) {
  Section& section = profile.sections.back();
  (inward ? section.inner_m : section.outer_m) = agreement.radius_m;
  (inward ? section.inner_points : section.outer_points) = agreement.last - agreement.first;
  for (std::size_t k = 0; k < members.size(); ++k) {
    const bool on_circle = k >= agreement.first && k < agreement.last;
    (!on_circle                      ? profile.differing
     : members[k].normal_passes_axis ? profile.agreeing
                                     : profile.turned)
        .push_back(members[k].point);
  }
}

/// A body point that faces outward: its section, and its position about the axis in the plane.
struct OuterPoint {
  int section;
  Vector2d radial;
};

std::vector<OuterPoint> OuterPoints(const PointCloud& cloud, const BodyProfile& body,
                                    const RotationAxis& axis, const Vector3d& u, const Vector3d& v,
                                    const FeatureOptions& options) {
  std::vector<OuterPoint> outer;
  for (const auto i : body.agreeing) {
    const Vector3d d = cloud.points[i] - axis.center_C;
    const Vector2d radial(d.dot(u), d.dot(v));
    if (cloud.normals[i].dot(radial.x() * u + radial.y() * v) < 0.0) continue;
    outer.push_back({SectionOf(-d.dot(axis.direction_C), options), radial});
  }
  return outer;
}

/// One Gauss-Newton step: how far the center is off. A point's residual is its distance from the
/// axis minus its section's radius, which follows the center by the section's mean direction.
/// @return nullopt if too few points, or too short an arc, determine it.
std::optional<Vector2d> CenterShift(const std::vector<OuterPoint>& points, const BodyProfile& body,
                                    const FeatureOptions& options) {
  std::map<int, double> radius_m;
  for (const Section& s : body.sections) radius_m[SectionOf(s.depth_m, options)] = s.outer_m;
  std::map<int, std::pair<Vector2d, int>> directions;  // sum over a section, and their number
  for (const OuterPoint& point : points) {
    auto& [sum, count] = directions.try_emplace(point.section, Vector2d::Zero(), 0).first->second;
    sum += point.radial.normalized();
    ++count;
  }
  Eigen::Matrix2d normal_matrix = Eigen::Matrix2d::Zero();
  Vector2d right = Vector2d::Zero();
  for (const OuterPoint& point : points) {
    const auto& [sum, count] = directions.at(point.section);
    const Vector2d g = point.radial.normalized() - sum / count;
    normal_matrix += g * g.transpose();
    right += g * (point.radial.norm() - radius_m.at(point.section));
  }
  const auto n = static_cast<double>(points.size());
  const auto eigen = base::SymmetricEigen(normal_matrix);
  if (n < options.axis.min_body_points || eigen.values[0] < options.axis.min_conditioning * n) {
    return std::nullopt;
  }
  return normal_matrix.inverse() * right;
}

/// Smoothing rounds the rim, so the wall under it gives the radius. 0 if it has too few points.
double RadiusUnderRim(const BodyProfile& body, const AxisOptions& options) {
  double sum = 0.0;
  double count = 0.0;
  for (const Section& s : body.sections) {
    if (s.depth_m < 0.0 || s.depth_m > options.top_sections_m) continue;
    sum += static_cast<double>(s.outer_points) * s.outer_m;
    count += static_cast<double>(s.outer_points);
  }
  return count >= options.min_body_points ? sum / count : 0.0;
}

}  // namespace

int SectionOf(double depth_m, const FeatureOptions& options) {
  return static_cast<int>(std::floor(depth_m / options.axis.section_m));
}

Indices OnCircle(const BodyProfile& body) {
  Indices on_circle;
  std::ranges::merge(body.agreeing, body.turned, std::back_inserter(on_circle));
  return on_circle;
}

Plane EndPlane(const RotationAxis& axis, const TopSurface& top) {
  return axis.Lies() ? geometry::PlaneAt(axis.direction_C, axis.center_C) : top.plane;
}

BodyProfile ProfileBody(const ObjectContext& context, const Indices& points, const Plane& top,
                        const RotationAxis& axis) {
  const FeatureOptions& options = context.options;
  BodyProfile profile;
  Members sections = BySection(context, points, top, axis);
  for (auto& [key, members] : sections) {
    const double depth = (key.first + 0.5) * options.axis.section_m;
    if (profile.sections.empty() || profile.sections.back().depth_m != depth) {
      profile.sections.push_back({depth, 0.0, 0.0, 0, 0});
    }
    AddMembers(members, Agree(members, options.circle.distance_m), key.second, profile);
  }
  const std::size_t on_circle = profile.agreeing.size() + profile.turned.size();
  const auto all = static_cast<double>(on_circle + profile.differing.size());
  if (all >= options.axis.min_body_points) {
    profile.fraction = static_cast<double>(on_circle) / all;
    profile.normal_fraction = static_cast<double>(profile.agreeing.size()) / all;
  }
  for (Indices* some : {&profile.agreeing, &profile.turned, &profile.differing}) {
    std::ranges::sort(*some);
  }
  return profile;
}

void RefineAxis(const ObjectContext& context, const Indices& points, const TopSurface& top,
                RotationAxis& axis) {
  const FeatureOptions& options = context.options;
  const Vector3d u = axis.direction_C.unitOrthogonal();
  const Vector3d v = axis.direction_C.cross(u);
  const double min_fraction = std::min(axis.body_fraction, options.axis.body_share);
  const Plane end = EndPlane(axis, top);
  RotationAxis refined = axis;
  for (int round = 0; round < options.axis.refine_rounds; ++round) {
    const BodyProfile body = ProfileBody(context, points, end, refined);
    const auto min_points = static_cast<std::size_t>(options.axis.min_body_points);
    if (body.fraction < min_fraction || body.agreeing.size() < min_points) return;
    const auto outer = OuterPoints(context.cloud, body, refined, u, v, options);
    const auto shift = CenterShift(outer, body, options);
    if (!shift) return;
    refined.center_C += shift->x() * u + shift->y() * v;
    if ((refined.center_C - axis.center_C).norm() > options.axis.max_shift_m) return;
  }
  const BodyProfile body = ProfileBody(context, points, end, refined);
  if (body.fraction < min_fraction) return;
  refined.body_fraction = body.fraction;
  const double radius_m = RadiusUnderRim(body, options.axis);
  if (radius_m > 0.0 && std::abs(radius_m - axis.radius_m) < options.axis.max_shift_m) {
    refined.radius_m = radius_m;
  }
  axis = refined;
}

}  // namespace rangegrasp::perception::internal
