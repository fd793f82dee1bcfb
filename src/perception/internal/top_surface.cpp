#include "perception/internal/top_surface.h"

#include <Eigen/Geometry>
#include <iterator>
#include <ranges>
#include <tuple>

#include "base/linear_algebra.h"
#include "base/statistics.h"
#include "geometry/alpha_shape.h"

namespace rangegrasp::perception::internal {
namespace {

std::size_t MinPlanePoints(const FeatureOptions& options) {
  return static_cast<std::size_t>(options.top.min_plane_points);
}

/// Shares of points that may lie beyond the ends of a ridge's length and height: strays.
constexpr double kEndShare = 0.05;
constexpr double kWidthEndShare = 0.02;
constexpr double kHeightShare = 0.8;
constexpr double kSpreadFrom = 0.2;
constexpr double kSpreadTo = 0.8;
/// A variance of sines below this is no spread and gives no slope.
constexpr double kNoVariance = 1e-9;

/// The direction that the normals are most nearly perpendicular to, and their mean square along it.
std::pair<Vector3d, double> CommonSquare(const PointCloud& cloud, const Indices& points) {
  Matrix3d scatter = Matrix3d::Zero();
  for (const auto i : points) scatter += cloud.normals[i] * cloud.normals[i].transpose();
  scatter /= static_cast<double>(points.size());
  const auto [values, vectors] = base::SymmetricEigen(scatter);
  return {vectors.col(0), values[0]};
}

/// An upward point, seen along the axis that the normals are perpendicular to.
struct Spot {
  double angle_rad;  ///< of its normal about the axis, 0 along Body::normal
  double sine;       ///< of the angle
  double offset_m;   ///< along Body::lateral
  double along_m;    ///< along the axis
  double height_m;   ///< along Body::normal
};

double Quantile(const std::vector<Spot>& spots, double Spot::*value, double share) {
  std::vector<double> values(spots.size());
  std::ranges::transform(spots, values.begin(), value);
  return base::QuantileOf(std::move(values), share);
}

double Between(const std::vector<Spot>& spots, double Spot::*value, double from, double to) {
  return Quantile(spots, value, to) - Quantile(spots, value, from);
}

/// Sums over x, the sines, and y, the offsets.
struct Sums {
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;

  explicit Sums(const std::vector<Spot>& spots) : n(static_cast<double>(spots.size())) {
    for (const Spot& spot : spots) {
      x += spot.sine;
      y += spot.offset_m;
      xx += spot.sine * spot.sine;
      yy += spot.offset_m * spot.offset_m;
      xy += spot.sine * spot.offset_m;
    }
  }
  double Correlation() const {
    const double variances = (n * xx - x * x) * (n * yy - y * y);
    return variances > 0.0 ? (n * xy - x * y) / std::sqrt(variances) : 0.0;
  }
  /// The least-squares line y = first + second x; a level one if all x are alike.
  std::pair<double, double> Line() const {
    const double variance = n * xx - x * x;
    if (variance <= kNoVariance * n * n) return {y / n, 0.0};
    const double slope = (n * xy - x * y) / variance;
    return {(y - slope * x) / n, slope};
  }
};

/// The upward points of a segment about the axis that their normals are perpendicular to.
struct Body {
  Vector3d axis;
  Vector3d normal;   ///< normal to the axis, as near to the table's as possible
  Vector3d lateral;  ///< axis x normal
  Vector3d origin;   ///< one of the points
  Indices points;
  std::vector<Spot> spots;  ///< the points
};

/// The axis and the points whose normals are perpendicular to it; nullopt if they are few or steep.
std::optional<Body> AboutOneAxis(const ObjectContext& context, const Indices& segment) {
  const auto& [cloud, table, views, options] = context;
  const Vector3d& up = table.normal;
  const Indices upward = UpwardPoints(cloud, segment, up, options.ridge.window_rad);
  // Each side of the ridge is a surface.
  if (upward.size() < 2 * MinPlanePoints(options)) return std::nullopt;
  Body body;
  body.axis = CommonSquare(cloud, upward).first;
  const auto is_square = [&](auto i) {
    return std::abs(cloud.normals[i].dot(body.axis)) < options.ridge.max_along_axis;
  };
  if (!HoldsForShare(options.ridge.min_square_share, upward, is_square)) return std::nullopt;
  body.points = Where(upward, is_square);
  double rest = 0.0;
  std::tie(body.axis, rest) = CommonSquare(cloud, body.points);
  if (rest > options.ridge.max_mean_square ||
      std::abs(body.axis.dot(up)) > options.ridge.max_axis_slope) {
    return std::nullopt;
  }
  return body;
}

void Measure(const PointCloud& cloud, const Vector3d& up, Body& body) {
  body.normal = (up - up.dot(body.axis) * body.axis).normalized();
  body.lateral = body.axis.cross(body.normal);
  body.origin = cloud.points[body.points.front()];
  for (const auto i : body.points) {
    const Vector3d& n = cloud.normals[i];
    const Vector3d d = cloud.points[i] - body.origin;
    const double angle_rad = std::atan2(n.dot(body.lateral), n.dot(body.normal));
    body.spots.push_back({angle_rad, std::sin(angle_rad), d.dot(body.lateral), d.dot(body.axis),
                          d.dot(body.normal)});
  }
}

/// Descent of points off the ridge, over that of an arc with their normals; 1 if none is off.
double DropOverArc(const std::vector<Spot>& spots, double off_ridge_rad, double height_m,
                   double radius_m) {
  double drop = 0.0;
  double arc = 0.0;
  for (const Spot& spot : spots) {
    if (std::abs(spot.angle_rad) < off_ridge_rad) continue;
    drop += height_m - spot.height_m;
    arc += radius_m * (1.0 - std::cos(spot.angle_rad));
  }
  return arc > 0.0 ? drop / arc : 1.0;
}

/// At most this many points, a tenth of a small part, may lie above the highest that counts:
/// strays. More would cut a pointed top.
constexpr std::size_t kStrays = 4;
constexpr std::size_t kStrayPart = 10;
/// A plane and a rim have at least three points.
constexpr std::size_t kMinCorners = 3;

Indices Near(const PointCloud& cloud, const Indices& points, const Plane& plane,
             double distance_m) {
  return Where(points,
               [&](auto i) { return std::abs(plane.Distance(cloud.points[i])) <= distance_m; });
}

/// Eq. 5.5, refitted.
std::optional<Plane> FullestPlane(const ObjectContext& context, const Indices& candidates,
                                  base::Rng& rng) {
  if (candidates.size() < kMinCorners) return std::nullopt;
  const auto& [cloud, table, views, options] = context;
  const double distance_m = options.top.plane_distance_m;
  const double min_cosine = std::cos(options.top.normal_angle_rad);
  const auto may_be = [&](const std::optional<Plane>& plane) {
    return plane &&
           (!options.level_tops || std::abs(plane->normal.dot(table.normal)) >= min_cosine);
  };
  const auto draw = [&] {
    const auto a = candidates[rng.Index(candidates.size())];
    const auto b = candidates[rng.Index(candidates.size())];
    const auto c = candidates[rng.Index(candidates.size())];
    const auto plane = geometry::PlaneThrough(cloud.points[a], cloud.points[b], cloud.points[c]);
    return may_be(plane) ? plane : std::nullopt;
  };
  const auto is_near = [&](const Plane& plane, std::uint32_t i) {
    return std::abs(plane.Distance(cloud.points[i])) <= distance_m;
  };
  auto [best, count] = BestOfDraws(options.top.plane_draws, draw, candidates, is_near);
  if (!best) return std::nullopt;
  const auto refit =
      geometry::FitPlane(Select(cloud.points, Near(cloud, candidates, *best, distance_m)));
  if (may_be(refit) && Near(cloud, candidates, *refit, distance_m).size() >= count) best = refit;
  return geometry::TurnedLike(table, *best);
}

/// The fullest plane, or one above it that has the options' share of its points.
std::optional<Plane> TopPlane(const ObjectContext& context, const Indices& candidates,
                              base::Rng& rng) {
  const auto& [cloud, table, views, options] = context;
  const double separation_m = options.top.plane_separation * options.top.plane_distance_m;
  Indices left = candidates;
  std::optional<Plane> top;
  double top_height = 0.0;
  std::size_t fullest = 0;
  for (int round = 0; round < options.top.planes; ++round) {
    const auto plane = FullestPlane(context, left, rng);
    if (!plane) break;
    const Indices inliers = Near(cloud, left, *plane, options.top.plane_distance_m);
    const double share = static_cast<double>(inliers.size()) / static_cast<double>(fullest);
    if ((options.slab_tops && inliers.size() < MinPlanePoints(options)) ||
        (top && (!options.higher_tops || share < options.top_plane_share)))
      break;
    double height = 0.0;
    for (const auto i : inliers) height += table.Distance(cloud.points[i]);
    height /= static_cast<double>(inliers.size());
    if (!top || height > top_height + separation_m) {
      top = plane;
      top_height = height;
    }
    if (round == 0) fullest = inliers.size();
    std::erase_if(
        left, [&](auto i) { return std::abs(plane->Distance(cloud.points[i])) <= separation_m; });
  }
  return top;
}

/// The longest loop that is no hole; empty if there is none.
Indices OuterLoop(const std::vector<Vector2d>& points, const geometry::AlphaShape2& shape) {
  for (const auto& loop : shape.loops) {
    double twice_area = 0.0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      twice_area += Cross(points[loop[i]], points[loop[(i + 1) % loop.size()]]);
    }
    if (twice_area > 0.0) return loop;
  }
  return {};
}

/// Fills in all values that follow from the points, the plane and (for a ridge) the axis.
void Describe(const ObjectContext& context, const std::optional<Vector3d>& axis, TopSurface& top) {
  const auto& [cloud, table, views, options] = context;
  const Points points = Select(cloud.points, top.points);
  top.center_C = geometry::Centroid(points);
  const PlanarFrame frame =
      MakePlanarFrame(top.plane, top.center_C, axis.value_or(Vector3d::Zero()));
  const auto flat = Flatten(frame, points);
  const Rectangle box = axis                     ? RectangleAlong(flat, Vector2d::UnitX())
                        : options.rectangle_axes ? MinAreaRectangle(flat)
                                                 : PrincipalRectangle(flat);
  top.major_C = WithoutSign(box.axis.x() * frame.u + box.axis.y() * frame.v);
  top.minor_C = top.plane.normal.cross(top.major_C);
  top.major_m = box.length_m;
  top.minor_m = box.width_m;
  const std::array<double, 2> alphas_m{options.top.rim_alpha_m, options.top.bridged_rim_alpha_m};
  auto rims = OuterRims(cloud, top.points, top.plane,
                        std::span(alphas_m).first(options.bridged_rims ? 2 : 1));
  top.rim = std::move(rims.front());
  if (options.bridged_rims) top.bridged_rim = std::move(rims.back());
}

std::optional<TopSurface> RidgeTop(const ObjectContext& context, const Indices& segment,
                                   const Ridge& ridge) {
  const auto& [cloud, table, views, options] = context;
  TopSurface top;
  top.ridge = true;
  const Vector3d lateral = ridge.axis.cross(ridge.normal);
  const double min_cosine = std::cos(options.ridge.half_angle_rad);
  top.points = Where(segment, [&](auto i) {
    const Vector3d across = cloud.normals[i] - cloud.normals[i].dot(ridge.axis) * ridge.axis;
    return cloud.normals[i].dot(ridge.normal) >= min_cosine * across.norm() &&
           std::abs((cloud.points[i] - ridge.point).dot(ridge.normal)) <= options.top.slab_m;
  });
  if (top.points.size() < MinPlanePoints(options)) return std::nullopt;
  top.plane = geometry::PlaneAt(ridge.normal, geometry::Centroid(Select(cloud.points, top.points)));
  Describe(context, ridge.axis, top);
  if (top.major_m < top.minor_m) return std::nullopt;
  // The scan is denser on the sensor's side, but the ridge is not off center.
  top.center_C += (ridge.point - top.center_C).dot(lateral) * lateral;
  return top;
}

/// The highest points if no plane is near the table's inclination.
std::optional<TopSurface> SlabTop(const ObjectContext& context, const Indices& segment) {
  const auto& [cloud, table, views, options] = context;
  const double height = TopHeight(cloud, segment, table);
  TopSurface top;
  top.points = Where(segment, [&](auto i) {
    return table.Distance(cloud.points[i]) >= height - options.top.slab_m;
  });
  if (top.points.size() < kMinCorners) return std::nullopt;
  top.plane = geometry::PlaneAt(table.normal, geometry::Centroid(Select(cloud.points, top.points)));
  Describe(context, std::nullopt, top);
  if (top.major_m <= 0.0 || top.rim.size() < kMinCorners) return std::nullopt;
  top.ridge = top.major_m > options.top.fold_elongation * top.minor_m;
  if (!top.ridge) return top;
  // Often only one side of the fold is seen: the strip lies next to it.
  const PlanarFrame frame = MakePlanarFrame(top.plane, top.center_C, top.major_C);
  top.center_C += HighestLine(frame, table, Select(cloud.points, top.points)) * frame.v;
  return top;
}

}  // namespace

Indices UpwardPoints(const PointCloud& cloud, const Indices& segment, const Vector3d& up,
                     double angle_rad) {
  const double min_cosine = std::cos(angle_rad);
  return Where(segment, [&](auto i) { return cloud.normals[i].dot(up) >= min_cosine; });
}

std::optional<Ridge> FindRidge(const ObjectContext& context, const Indices& segment) {
  const RidgeOptions& asked = context.options.ridge;
  auto body = AboutOneAxis(context, segment);
  if (!body) return std::nullopt;
  Measure(context.cloud, context.table.normal, *body);
  const std::vector<Spot>& spots = body->spots;
  if (Between(spots, &Spot::angle_rad, kSpreadFrom, kSpreadTo) < asked.min_spread_rad ||
      Sums(spots).Correlation() < asked.min_correlation) {
    return std::nullopt;
  }
  std::vector<Spot> strip;
  std::ranges::copy_if(spots, std::back_inserter(strip), [&](const Spot& spot) {
    return std::abs(spot.angle_rad) <= asked.half_angle_rad;
  });
  if (strip.size() < MinPlanePoints(context.options)) return std::nullopt;
  const auto length = [](const std::vector<Spot>& of) {
    return Between(of, &Spot::along_m, kEndShare, 1.0 - kEndShare);
  };
  if (length(strip) < asked.min_length_share * length(spots)) return std::nullopt;

  const auto [u, radius] = Sums(strip).Line();
  const double height = Quantile(strip, &Spot::height_m, kHeightShare);
  // A flat top would require a descent for which its edges are too near.
  const double half_width =
      0.5 * Between(spots, &Spot::offset_m, kWidthEndShare, 1.0 - kWidthEndShare);
  if (DropOverArc(spots, asked.off_ridge_rad, height, std::min(radius, half_width)) <
      asked.min_drop_share) {
    return std::nullopt;
  }
  return Ridge{body->axis, body->normal, body->origin + u * body->lateral + height * body->normal};
}

double OpenSphereRadius(const ObjectContext& context, const TopSurface& top) {
  if (top.rim.empty()) return 0.0;
  const auto distance = [&](auto i) { return (context.cloud.points[i] - top.center_C).norm(); };
  return context.options.open_sphere_factor *
         std::ranges::min(top.rim | std::views::transform(distance));
}

bool IsOpen(const ObjectContext& context, const Indices& object, const TopSurface& top) {
  const auto& [cloud, table, views, options] = context;
  const double radius = OpenSphereRadius(context, top);
  if (radius <= 0.0) return false;
  const auto inside = std::ranges::count_if(
      object, [&](auto i) { return (cloud.points[i] - top.center_C).norm() < radius; });
  const double strays =
      options.open_strays ? options.open_stray_share * static_cast<double>(top.points.size()) : 0.0;
  return static_cast<double>(inside) <= strays;
}

double TopHeight(const PointCloud& cloud, const Indices& points, const Plane& table) {
  if (points.empty()) return 0.0;
  std::vector<double> heights;
  heights.reserve(points.size());
  for (const auto i : points) heights.push_back(table.Distance(cloud.points[i]));
  const auto k =
      heights.begin() + static_cast<std::ptrdiff_t>(std::min(kStrays, heights.size() / kStrayPart));
  std::ranges::nth_element(heights, k, std::ranges::greater());
  return *k;
}

double BaseHeight(const PointCloud& cloud, const Indices& points, const Plane& table) {
  return -TopHeight(cloud, points, table.Flipped());
}

std::vector<Indices> OuterRims(const PointCloud& cloud, const Indices& points, const Plane& plane,
                               std::span<const double> alphas_m) {
  std::vector<Indices> rims(alphas_m.size());
  if (points.empty()) return rims;
  const auto flat =
      Flatten(MakePlanarFrame(plane, cloud.points[points.front()]), Select(cloud.points, points));
  const auto shapes = geometry::BuildAlphaShapes2(flat, alphas_m);
  for (std::size_t k = 0; k < rims.size(); ++k) {
    auto rim = OuterLoop(flat, shapes[k]);
    if (rim.empty()) rim = HullPositions(flat);
    for (const auto i : rim) rims[k].push_back(points[i]);
  }
  return rims;
}

std::optional<TopSurface> FindLip(const ObjectContext& context, const Indices& segment) {
  auto lip = SlabTop(context, segment);
  return lip && lip->ridge ? std::nullopt : lip;
}

std::optional<TopSurface> FindTopSurface(const ObjectContext& context, const Indices& segment,
                                         base::Rng& rng) {
  if (segment.size() < kMinCorners) return std::nullopt;
  const auto& [cloud, table, views, options] = context;
  if (options.ridge_tops) {
    const auto ridge = FindRidge(context, segment);
    auto top = ridge ? RidgeTop(context, segment, *ridge) : std::nullopt;
    if (top) return top;
  }
  const Indices candidates =
      UpwardPoints(cloud, segment, table.normal, options.top.normal_angle_rad);
  const auto min_upward =
      static_cast<std::size_t>(options.top.min_upward_share * static_cast<double>(segment.size()));
  if (!options.slab_tops || candidates.size() >= std::max(MinPlanePoints(options), min_upward)) {
    if (const auto plane = TopPlane(context, candidates, rng)) {
      TopSurface top;
      top.plane = *plane;
      top.points = Near(cloud, segment, *plane, options.top.plane_distance_m);
      Describe(context, std::nullopt, top);
      if (top.major_m > 0.0 && top.rim.size() >= kMinCorners) return top;
    }
  }
  if (!options.slab_tops) return std::nullopt;
  return SlabTop(context, segment);
}

}  // namespace rangegrasp::perception::internal
