#include "perception/internal/rotation_axis.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/units.h"
#include "perception/internal/axis_from_body.h"
#include "perception/internal/axis_refinement.h"
#include "perception/internal/body_profile.h"
#include "perception/internal/top_surface.h"

namespace rangegrasp::perception::internal {
namespace {

using geometry::Indices;
using geometry::PointCloud;

/// Bins of an arc, 10 deg each: a rim of 35 mm radius has three points in one. Fewer bins count a
/// few points as a long arc, more count the gaps between points.
constexpr int kArcBins = 36;

/// The first rule.
std::optional<RotationAxis> AxisFromRim(const PointCloud& cloud, const Indices& rim,
                                        const TopSurface& top, double min_arc_rad,
                                        const FeatureOptions& options, core::Rng& rng) {
  const auto fit = FitCircle(geometry::Select(cloud.points, rim), options.circle, rng);
  if (!fit) return std::nullopt;
  const double share = static_cast<double>(fit->inliers.size()) / static_cast<double>(rim.size());
  Indices on_circle;
  for (const auto k : fit->inliers) on_circle.push_back(rim[k]);
  if (share < options.axis.rim_share ||
      (options.arc_rule && ArcOf(cloud, on_circle, fit->circle) < min_arc_rad)) {
    return std::nullopt;
  }
  return RotationAxis{fit->circle.center, top.plane.normal, fit->circle.radius_m, share, 0.0};
}

/// The second rule, with the better of the plane's normal and the vertical.
bool BodyAgrees(const PointCloud& cloud, const Indices& points, const TopSurface& top,
                const geometry::Plane& table, double min_share, const FeatureOptions& options,
                RotationAxis& axis) {
  const Eigen::Vector3d leaning = axis.direction_C;
  axis.body_fraction = ProfileBody(cloud, points, top, axis.center_C, leaning, options).fraction;
  if (options.upright_axes && leaning.dot(table.normal) > std::cos(options.axis.upright_rad)) {
    const double upright =
        ProfileBody(cloud, points, top, axis.center_C, table.normal, options).fraction;
    if (upright >= axis.body_fraction) {
      axis.direction_C = table.normal;
      axis.body_fraction = upright;
    }
  }
  return axis.body_fraction >= min_share;
}

/// The axis of a thin ring, whose rim has too few points.
std::optional<RotationAxis> AxisOfThinRing(const PointCloud& cloud, const Indices& points,
                                           const TopSurface& top, const geometry::Plane& table,
                                           const FeatureOptions& options, core::Rng& rng) {
  auto axis = AxisFromBody(cloud, points, top, table, options, rng);
  if (!axis || !IsThinRing(cloud, top, *axis, options) ||
      !BodyAgrees(cloud, points, top, table, options.axis.ring_body_share, options, *axis)) {
    return std::nullopt;
  }
  const BodyProfile body =
      ProfileBody(cloud, points, top, axis->center_C, axis->direction_C, options);
  const Circle circle{axis->center_C, axis->direction_C, axis->radius_m};
  if (ArcOf(cloud, body.agreeing, circle) < options.axis.min_arc_rad) return std::nullopt;
  return axis;
}

}  // namespace

double ArcOf(const PointCloud& cloud, const Indices& points, const Circle& circle) {
  const Eigen::Vector3d u = circle.normal.unitOrthogonal();
  const Eigen::Vector3d v = circle.normal.cross(u);
  std::vector<bool> seen(kArcBins, false);
  for (const auto i : points) {
    const Eigen::Vector3d d = cloud.points[i] - circle.center;
    const double turn = std::atan2(d.dot(v), d.dot(u)) / (2.0 * core::kPi) + 0.5;
    seen[std::min<std::size_t>(kArcBins - 1, static_cast<std::size_t>(turn * kArcBins))] = true;
  }
  return 2.0 * core::kPi * static_cast<double>(std::count(seen.begin(), seen.end(), true)) /
         kArcBins;
}

double ShareOnCircle(const PointCloud& cloud, const Indices& points, const Circle& circle,
                     double distance_m) {
  if (points.empty()) return 0.0;
  const auto on = std::count_if(points.begin(), points.end(), [&](auto i) {
    return CircleDistance(circle, cloud.points[i]) <= distance_m;
  });
  return static_cast<double>(on) / static_cast<double>(points.size());
}

std::optional<RotationAxis> FindRotationAxis(const PointCloud& cloud, const Indices& points,
                                             const TopSurface& top, const geometry::Plane& table,
                                             const FeatureOptions& options, core::Rng& rng) {
  std::optional<RotationAxis> axis;
  for (const bool bridged : {false, true}) {
    if (top.ridge || (bridged && !options.bridged_rims)) break;
    const Indices rim =
        bridged ? OuterRim(cloud, top.points, top.plane, options.top.bridged_rim_alpha_m) : top.rim;
    const double min_arc = bridged ? options.axis.min_bridged_arc_rad : options.axis.min_arc_rad;
    axis = AxisFromRim(cloud, rim, top, min_arc, options, rng);
    if (axis && BodyAgrees(cloud, points, top, table, options.axis.body_share, options, *axis)) {
      if (options.refine_axis) RefineAxis(cloud, points, top, options, *axis);
      return axis;
    }
  }
  if (!options.axis_from_body) return std::nullopt;
  axis = AxisOfThinRing(cloud, points, top, table, options, rng);
  if (axis && options.refine_axis) RefineAxis(cloud, points, top, options, *axis);
  return axis;
}

}  // namespace rangegrasp::perception::internal
