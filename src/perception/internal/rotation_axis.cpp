#include "perception/internal/rotation_axis.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "base/units.h"
#include "perception/internal/axis_from_body.h"
#include "perception/internal/axis_refinement.h"
#include "perception/internal/body_profile.h"
#include "perception/internal/lying_axis.h"
#include "perception/internal/top_surface.h"

namespace rangegrasp::perception::internal {
namespace {

using geometry::Indices;
using geometry::PointCloud;

/// The first rule.
std::optional<RotationAxis> AxisFromRim(const PointCloud& cloud, const Indices& rim,
                                        const TopSurface& top, double min_arc_rad,
                                        const FeatureOptions& options, base::Rng& rng) {
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

/// The body about the better of the axis' direction and the vertical, which becomes the axis'.
BodyProfile BodyOf(const PointCloud& cloud, const Indices& points, const TopSurface& top,
                   const geometry::Plane& table, const FeatureOptions& options,
                   RotationAxis& axis) {
  BodyProfile body =
      ProfileBody(cloud, points, top.plane, axis.center_C, axis.direction_C, options);
  if (options.upright_axes &&
      axis.direction_C.dot(table.normal) > std::cos(options.axis.upright_rad)) {
    BodyProfile upright =
        ProfileBody(cloud, points, top.plane, axis.center_C, table.normal, options);
    if (upright.fraction >= body.fraction) {
      axis.direction_C = table.normal;
      body = std::move(upright);
    }
  }
  axis.body_fraction = body.fraction;
  return body;
}

/// The second rule, and what the normals say to it.
bool Agrees(const BodyProfile& body, double min_share, const FeatureOptions& options) {
  return body.fraction >= min_share &&
         (!options.radial_normals || body.normal_fraction >= options.axis.normal_share);
}

/// How far round the axis the circles are seen: the mean over the points of their section's arc, so
/// that a round cap does not speak for a flat bottle under it.
double MeanArc(const PointCloud& cloud, const BodyProfile& body, const RotationAxis& axis,
               const FeatureOptions& options) {
  std::map<int, Indices> sections;
  const Indices on_circle = OnCircle(body);
  for (const auto i : on_circle) {
    const double depth = (axis.center_C - cloud.points[i]).dot(axis.direction_C);
    sections[SectionOf(depth, options)].push_back(i);
  }
  double sum = 0.0;
  const Circle circle{axis.center_C, axis.direction_C, axis.radius_m};
  for (const auto& [section, points] : sections) {
    sum += static_cast<double>(points.size()) * ArcOf(cloud, points, circle);
  }
  return sum / static_cast<double>(std::max<std::size_t>(1, on_circle.size()));
}

/// Whether what is on the circles goes this far round the axis. A lid alone says nothing of that.
bool GoesRound(const PointCloud& cloud, const BodyProfile& body, const RotationAxis& axis,
               double min_arc_rad, const FeatureOptions& options) {
  if (!options.arc_rule) return true;
  const auto seen = body.agreeing.size() + body.turned.size();
  return seen < static_cast<std::size_t>(options.axis.min_body_points) ||
         MeanArc(cloud, body, axis, options) >= min_arc_rad;
}

/// The axis of a body whose rim gives no circle: its lip is too thin, or its lid has holes.
std::optional<RotationAxis> AxisOfWall(const PointCloud& cloud, const Indices& points,
                                       const TopSurface& top, const geometry::Plane& table,
                                       const FeatureOptions& options, base::Rng& rng) {
  auto axis = AxisFromBody(cloud, points, top, table, options, rng);
  if (!axis) return std::nullopt;
  const bool ring = IsThinRing(cloud, top, *axis, options);
  if (!ring && !IsLid(cloud, top, *axis, options)) return std::nullopt;
  const BodyProfile body = BodyOf(cloud, points, top, table, options, *axis);
  const double min_share = ring ? options.axis.ring_body_share : options.axis.body_share;
  const double min_arc = ring ? options.axis.min_ring_arc_rad : options.axis.min_body_arc_rad;
  if (!Agrees(body, min_share, options) || !GoesRound(cloud, body, *axis, min_arc, options)) {
    return std::nullopt;
  }
  return axis;
}

/// From its rim, else from its wall; not refined yet.
std::optional<RotationAxis> StandingAxis(const PointCloud& cloud, const Indices& points,
                                         const TopSurface& top, const geometry::Plane& table,
                                         const FeatureOptions& options, base::Rng& rng) {
  for (const bool bridged : {false, true}) {
    if (top.ridge || (bridged && !options.bridged_rims)) break;
    const Indices& rim = bridged ? top.bridged_rim : top.rim;
    const double min_arc = bridged ? options.axis.min_bridged_arc_rad : options.axis.min_arc_rad;
    auto axis = AxisFromRim(cloud, rim, top, min_arc, options, rng);
    if (!axis) continue;
    const BodyProfile body = BodyOf(cloud, points, top, table, options, *axis);
    if (Agrees(body, options.axis.body_share, options) &&
        GoesRound(cloud, body, *axis, options.axis.min_body_arc_rad, options)) {
      return axis;
    }
  }
  if (!options.axis_from_body) return std::nullopt;
  return AxisOfWall(cloud, points, top, table, options, rng);
}

}  // namespace

double ShareOnCircle(const PointCloud& cloud, const Indices& points, const Circle& circle,
                     double distance_m) {
  if (points.empty()) return 0.0;
  const auto on = std::count_if(points.begin(), points.end(), [&](auto i) {
    return CircleDistance(circle, cloud.points[i]) <= distance_m;
  });
  return static_cast<double>(on) / static_cast<double>(points.size());
}

std::optional<RotationAxis> FindStandingAxis(const PointCloud& cloud, const Indices& points,
                                             const TopSurface& top, const geometry::Plane& table,
                                             const FeatureOptions& options, base::Rng& rng) {
  auto axis = StandingAxis(cloud, points, top, table, options, rng);
  if (axis && options.refine_axis) RefineAxis(cloud, points, top, options, *axis);
  return axis;
}

std::optional<RotationAxis> FindRotationAxis(const PointCloud& cloud, const Indices& points,
                                             const TopSurface& top, const geometry::Plane& table,
                                             const FeatureOptions& options, base::Rng& rng) {
  auto axis = FindStandingAxis(cloud, points, top, table, options, rng);
  if (axis || !options.lying_axes) return axis;
  axis = FindLyingAxis(cloud, points, table, options, rng);
  if (axis && options.refine_axis) RefineAxis(cloud, points, top, options, *axis);
  return axis;
}

}  // namespace rangegrasp::perception::internal
