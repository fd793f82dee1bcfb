#include "perception/internal/axis_refinement.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "perception/internal/body_profile.h"

namespace rangegrasp::perception::internal {
namespace {

using geometry::Indices;
using geometry::PointCloud;

/// A body point that faces outward: its section, and where it is about the axis, in the plane.
struct OuterPoint {
  int section;
  Eigen::Vector2d radial;
};

/// Two unit vectors square to the axis and to each other.
struct Basis {
  Eigen::Vector3d u;
  Eigen::Vector3d v;
};

std::vector<OuterPoint> OuterPoints(const PointCloud& cloud, const BodyProfile& body,
                                    const RotationAxis& axis, const Basis& basis,
                                    const FeatureOptions& options) {
  std::vector<OuterPoint> outer;
  for (const auto i : body.agreeing) {
    const Eigen::Vector3d d = cloud.points[i] - axis.center_C;
    const Eigen::Vector2d radial(d.dot(basis.u), d.dot(basis.v));
    if (cloud.normals[i].dot(radial.x() * basis.u + radial.y() * basis.v) < 0.0) continue;
    outer.push_back({SectionOf(-d.dot(axis.direction_C), options), radial});
  }
  return outer;
}

/// The sum of the directions of each section's points, and how many there are.
std::map<int, std::pair<Eigen::Vector2d, int>> Directions(const std::vector<OuterPoint>& points) {
  std::map<int, std::pair<Eigen::Vector2d, int>> directions;
  for (const OuterPoint& point : points) {
    auto& [sum, count] =
        directions.try_emplace(point.section, Eigen::Vector2d::Zero(), 0).first->second;
    sum += point.radial.normalized();
    ++count;
  }
  return directions;
}

/// One step of Gauss-Newton: how far the center is off. A point's residual is its distance from the
/// axis less its section's radius, which follows the center by the section's mean direction.
/// @return nullopt where too few points, or too short an arc, say where it is.
std::optional<Eigen::Vector2d> CenterShift(const std::vector<OuterPoint>& points,
                                           const BodyProfile& body, const FeatureOptions& options) {
  std::map<int, double> radius_m;
  for (const Section& s : body.sections) radius_m[SectionOf(s.depth_m, options)] = s.outer_m;
  const auto directions = Directions(points);
  Eigen::Matrix2d normal_matrix = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const OuterPoint& point : points) {
    const auto& [sum, count] = directions.at(point.section);
    const Eigen::Vector2d g = point.radial.normalized() - sum / count;
    normal_matrix += g * g.transpose();
    right += g * (point.radial.norm() - radius_m.at(point.section));
  }
  const auto n = static_cast<double>(points.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(normal_matrix);
  if (n < options.axis.min_body_points ||
      eigen.eigenvalues()[0] < options.axis.min_conditioning * n) {
    return std::nullopt;
  }
  return normal_matrix.inverse() * right;
}

/// Smoothing rounds the rim; the wall under it gives the radius. 0 where it has too few points.
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

void RefineAxis(const PointCloud& cloud, const Indices& points, const TopSurface& top,
                const FeatureOptions& options, RotationAxis& axis) {
  const Eigen::Vector3d u = axis.direction_C.unitOrthogonal();
  const Basis basis{u, axis.direction_C.cross(u)};
  const double min_fraction = std::min(axis.body_fraction, options.axis.body_share);
  const geometry::Plane end = EndPlane(axis, top);
  RotationAxis refined = axis;
  const auto profile = [&] {
    return ProfileBody(cloud, points, end, refined.center_C, refined.direction_C, options);
  };
  for (int round = 0; round < options.axis.refine_rounds; ++round) {
    const BodyProfile body = profile();
    if (body.fraction < min_fraction ||
        body.agreeing.size() < static_cast<std::size_t>(options.axis.min_body_points)) {
      return;
    }
    const auto outer = OuterPoints(cloud, body, refined, basis, options);
    const auto shift = CenterShift(outer, body, options);
    if (!shift) return;
    refined.center_C += shift->x() * basis.u + shift->y() * basis.v;
    if ((refined.center_C - axis.center_C).norm() > options.axis.max_shift_m) return;
  }
  const BodyProfile body = profile();
  if (body.fraction < min_fraction) return;
  refined.body_fraction = body.fraction;
  const double radius_m = RadiusUnderRim(body, options.axis);
  if (radius_m > 0.0 && std::abs(radius_m - axis.radius_m) < options.axis.max_shift_m) {
    refined.radius_m = radius_m;
  }
  axis = refined;
}

}  // namespace rangegrasp::perception::internal
