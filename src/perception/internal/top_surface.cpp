#include "perception/internal/top_surface.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "base/count_to_beat.h"
#include "geometry/alpha_shape.h"
#include "perception/internal/planar.h"
#include "perception/internal/ridge.h"

namespace rangegrasp::perception::internal {
namespace {

using geometry::Indices;
using geometry::Plane;
using geometry::PointCloud;

/// The highest point that counts has this many above it, fewer (a tenth) in a small part: a stray
/// point or two do not make an object higher. More would cut a pointed top.
constexpr std::size_t kStrays = 4;
constexpr std::size_t kStrayPart = 10;
/// A plane and a rim have at least three points.
constexpr std::size_t kMinCorners = 3;

std::size_t MinPlanePoints(const FeatureOptions& options) {
  return static_cast<std::size_t>(options.top.min_plane_points);
}

std::vector<double> Heights(const PointCloud& cloud, const Indices& points, const Plane& table) {
  std::vector<double> heights;
  heights.reserve(points.size());
  for (const auto i : points) heights.push_back(table.Distance(cloud.points[i]));
  return heights;
}

Indices Near(const PointCloud& cloud, const Indices& points, const Plane& plane,
             double distance_m) {
  Indices near;
  for (const auto i : points) {
    if (std::abs(plane.Distance(cloud.points[i])) <= distance_m) near.push_back(i);
  }
  return near;
}

/// How many, if it is more than `to_beat`.
std::size_t CountNear(const PointCloud& cloud, const Indices& points, const Plane& plane,
                      double distance_m, std::size_t to_beat) {
  return base::CountToBeat(points, to_beat, [&](std::uint32_t i) {
    return std::abs(plane.Distance(cloud.points[i])) <= distance_m;
  });
}

Plane TurnedUp(const Plane& plane, const Eigen::Vector3d& up) {
  return plane.normal.dot(up) < 0.0 ? Plane{-plane.normal, -plane.offset_m} : plane;
}

/// Eq. 5.5 among planes that are themselves within the angle of the table; refitted.
std::optional<Plane> FullestPlane(const PointCloud& cloud, const Indices& candidates,
                                  const Eigen::Vector3d& up, const FeatureOptions& options,
                                  base::Rng& rng) {
  if (candidates.size() < kMinCorners) return std::nullopt;
  const double min_cosine = std::cos(options.top.normal_angle_rad);
  std::optional<Plane> best;
  std::size_t best_count = 0;
  for (int draw = 0; draw < options.top.plane_draws; ++draw) {
    const auto a = candidates[rng.Index(candidates.size())];
    const auto b = candidates[rng.Index(candidates.size())];
    const auto c = candidates[rng.Index(candidates.size())];
    const auto plane = geometry::PlaneThrough(cloud.points[a], cloud.points[b], cloud.points[c]);
    if (!plane || std::abs(plane->normal.dot(up)) < min_cosine) continue;
    const std::size_t count =
        CountNear(cloud, candidates, *plane, options.top.plane_distance_m, best_count);
    if (count > best_count) {
      best_count = count;
      best = plane;
    }
  }
  if (!best) return std::nullopt;
  const auto refit = geometry::FitPlane(
      geometry::Select(cloud.points, Near(cloud, candidates, *best, options.top.plane_distance_m)));
  if (refit && std::abs(refit->normal.dot(up)) >= min_cosine &&
      CountNear(cloud, candidates, *refit, options.top.plane_distance_m, best_count - 1) >=
          best_count) {
    best = refit;
  }
  return TurnedUp(*best, up);
}

double MeanHeight(const PointCloud& cloud, const Indices& points, const Plane& table) {
  double sum = 0.0;
  for (const auto i : points) sum += table.Distance(cloud.points[i]);
  return sum / static_cast<double>(points.size());
}

/// The fullest plane, or one above it that holds the options' share of its points.
std::optional<Plane> TopPlane(const PointCloud& cloud, const Indices& candidates,
                              const Plane& table, const FeatureOptions& options, base::Rng& rng) {
  Indices left = candidates;
  std::optional<Plane> top;
  double top_height = 0.0;
  std::size_t fullest = 0;
  for (int round = 0; round < options.top.planes; ++round) {
    const auto plane = FullestPlane(cloud, left, table.normal, options, rng);
    if (!plane) break;
    const Indices inliers = Near(cloud, left, *plane, options.top.plane_distance_m);
    const double share = static_cast<double>(inliers.size()) / static_cast<double>(fullest);
    if ((options.slab_tops && inliers.size() < MinPlanePoints(options)) ||
        (top && (!options.higher_tops || share < options.top_plane_share)))
      break;
    const double height = MeanHeight(cloud, inliers, table);
    if (!top || height > top_height + options.top.plane_separation * options.top.plane_distance_m) {
      top = plane;
      top_height = height;
    }
    if (round == 0) fullest = inliers.size();
    std::erase_if(left, [&](auto i) {
      return std::abs(plane->Distance(cloud.points[i])) <=
             options.top.plane_separation * options.top.plane_distance_m;
    });
  }
  return top;
}

/// The longest loop that is no hole; empty if there is none.
Indices OuterLoop(const std::vector<Eigen::Vector2d>& points, const geometry::AlphaShape2& shape) {
  for (const auto& loop : shape.loops) {
    double twice_area = 0.0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      twice_area += Cross(points[loop[i]], points[loop[(i + 1) % loop.size()]]);
    }
    if (twice_area > 0.0) return loop;
  }
  return {};
}

/// Fills all that follows from the points, the plane and (for a ridge) the axis.
void Describe(const PointCloud& cloud, const std::optional<Eigen::Vector3d>& axis,
              const FeatureOptions& options, TopSurface& top) {
  const geometry::Points points = geometry::Select(cloud.points, top.points);
  top.center_C = geometry::Centroid(points);
  const PlanarFrame frame =
      MakePlanarFrame(top.plane, top.center_C, axis.value_or(Eigen::Vector3d::Zero()));
  const auto flat = Flatten(frame, points);
  const Rectangle box = axis                     ? RectangleAlong(flat, Eigen::Vector2d::UnitX())
                        : options.rectangle_axes ? MinAreaRectangle(flat)
                                                 : PrincipalRectangle(flat);
  top.major_C = box.axis.x() * frame.u + box.axis.y() * frame.v;
  Eigen::Index main = 0;  // its sign tells the axis from its opposite
  top.major_C.cwiseAbs().maxCoeff(&main);
  if (top.major_C[main] < 0.0) top.major_C = -top.major_C;
  top.minor_C = top.plane.normal.cross(top.major_C);
  top.major_m = box.length_m;
  top.minor_m = box.width_m;
  const std::array<double, 2> alphas_m{options.top.rim_alpha_m, options.top.bridged_rim_alpha_m};
  auto rims = OuterRims(cloud, top.points, top.plane,
                        std::span(alphas_m).first(options.bridged_rims ? 2 : 1));
  top.rim = std::move(rims.front());
  if (options.bridged_rims) top.bridged_rim = std::move(rims.back());
}

std::optional<TopSurface> RidgeTop(const PointCloud& cloud, const Indices& segment,
                                   const Ridge& ridge, const FeatureOptions& options) {
  TopSurface top;
  top.ridge = true;
  const Eigen::Vector3d lateral = ridge.axis.cross(ridge.normal);
  const double min_cosine = std::cos(options.ridge.half_angle_rad);
  for (const auto i : segment) {
    const Eigen::Vector3d across = cloud.normals[i] - cloud.normals[i].dot(ridge.axis) * ridge.axis;
    if (cloud.normals[i].dot(ridge.normal) >= min_cosine * across.norm() &&
        std::abs((cloud.points[i] - ridge.point).dot(ridge.normal)) <= options.top.slab_m) {
      top.points.push_back(i);
    }
  }
  if (top.points.size() < MinPlanePoints(options)) return std::nullopt;
  const Eigen::Vector3d mean = geometry::Centroid(geometry::Select(cloud.points, top.points));
  top.plane = {ridge.normal, -ridge.normal.dot(mean)};
  Describe(cloud, ridge.axis, options, top);
  if (top.major_m < top.minor_m) return std::nullopt;
  // The scan is denser on the sensor's side; the ridge itself is not.
  top.center_C += (ridge.point - top.center_C).dot(lateral) * lateral;
  return top;
}

/// The highest points where nothing is near the table's inclination.
std::optional<TopSurface> SlabTop(const PointCloud& cloud, const Indices& segment,
                                  const Plane& table, const FeatureOptions& options) {
  const double height = TopHeight(cloud, segment, table);
  TopSurface top;
  for (const auto i : segment) {
    if (table.Distance(cloud.points[i]) >= height - options.top.slab_m) top.points.push_back(i);
  }
  if (top.points.size() < kMinCorners) return std::nullopt;
  const Eigen::Vector3d mean = geometry::Centroid(geometry::Select(cloud.points, top.points));
  top.plane = {table.normal, -table.normal.dot(mean)};
  Describe(cloud, std::nullopt, options, top);
  if (top.major_m <= 0.0 || top.rim.size() < kMinCorners) return std::nullopt;
  top.ridge = top.major_m > options.top.fold_elongation * top.minor_m;
  if (!top.ridge) return top;
  // Often only one side of the fold is seen: the strip lies beside it.
  const PlanarFrame frame = MakePlanarFrame(top.plane, top.center_C, top.major_C);
  top.center_C += HighestLine(frame, table, geometry::Select(cloud.points, top.points)) * frame.v;
  return top;
}

}  // namespace

double TopHeight(const PointCloud& cloud, const Indices& points, const Plane& table) {
  if (points.empty()) return 0.0;
  std::vector<double> heights = Heights(cloud, points, table);
  const std::size_t k = std::min(kStrays, heights.size() / kStrayPart);
  std::nth_element(heights.begin(), heights.begin() + static_cast<std::ptrdiff_t>(k), heights.end(),
                   std::greater<>());
  return heights[k];
}

double BaseHeight(const PointCloud& cloud, const Indices& points, const Plane& table) {
  return -TopHeight(cloud, points, {-table.normal, -table.offset_m});
}

std::vector<Indices> OuterRims(const PointCloud& cloud, const Indices& points, const Plane& plane,
                               std::span<const double> alphas_m) {
  std::vector<Indices> rims(alphas_m.size());
  if (points.empty()) return rims;
  const auto flat = Flatten(MakePlanarFrame(plane, cloud.points[points.front()]),
                            geometry::Select(cloud.points, points));
  const auto shapes = geometry::BuildAlphaShapes2(flat, alphas_m);
  for (std::size_t k = 0; k < rims.size(); ++k) {
    auto rim = OuterLoop(flat, shapes[k]);
    if (rim.empty()) rim = HullPositions(flat);
    for (const auto i : rim) rims[k].push_back(points[i]);
  }
  return rims;
}

std::optional<TopSurface> FindLip(const PointCloud& cloud, const Indices& segment,
                                  const Plane& table, const FeatureOptions& options) {
  auto lip = SlabTop(cloud, segment, table, options);
  if (lip && lip->ridge) return std::nullopt;
  return lip;
}

std::optional<TopSurface> FindTopSurface(const PointCloud& cloud, const Indices& segment,
                                         const Plane& table, const FeatureOptions& options,
                                         base::Rng& rng) {
  if (segment.size() < kMinCorners) return std::nullopt;
  if (options.ridge_tops) {
    if (const auto ridge = FindRidge(cloud, segment, table, options)) {
      if (auto top = RidgeTop(cloud, segment, *ridge, options)) return top;
    }
  }
  const Indices candidates =
      UpwardPoints(cloud, segment, table.normal, options.top.normal_angle_rad);
  const auto min_upward =
      static_cast<std::size_t>(options.top.min_upward_share * static_cast<double>(segment.size()));
  if (!options.slab_tops || candidates.size() >= std::max(MinPlanePoints(options), min_upward)) {
    if (const auto plane = TopPlane(cloud, candidates, table, options, rng)) {
      TopSurface top;
      top.plane = *plane;
      top.points = Near(cloud, segment, *plane, options.top.plane_distance_m);
      Describe(cloud, std::nullopt, options, top);
      if (top.major_m > 0.0 && top.rim.size() >= kMinCorners) return top;
    }
  }
  if (!options.slab_tops) return std::nullopt;
  return SlabTop(cloud, segment, table, options);
}

}  // namespace rangegrasp::perception::internal
