#include "perception/top_surface.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>

#include "geometry/alpha_shape.h"
#include "perception/planar.h"

namespace rangegrasp::perception {
namespace {

using geometry::Indices;
using geometry::Plane;
using geometry::PointCloud;

// A plane with fewer points than this is no surface.
constexpr std::size_t kLeastPlanePoints = 12;
// Depth of the slab of highest points that stands in for a plane: what a plane's inliers span.
constexpr double kSlab_m = 0.004;
// A slab this many times as long as wide is a fold; else it is the lip of something.
constexpr double kFoldElongation = 4.0;

std::vector<double> Heights(const PointCloud& cloud, const Indices& points, const Plane& table) {
  std::vector<double> heights;
  heights.reserve(points.size());
  for (const auto i : points) heights.push_back(table.Distance(cloud.points[i]));
  return heights;
}

Indices UpwardPoints(const PointCloud& cloud, const Indices& segment, const Eigen::Vector3d& up,
                     double angle_rad) {
  const double least = std::cos(angle_rad);
  Indices upward;
  for (const auto i : segment) {
    if (cloud.normals[i].dot(up) >= least) upward.push_back(i);
  }
  return upward;
}

Indices Near(const PointCloud& cloud, const Indices& points, const Plane& plane,
             double distance_m) {
  Indices near;
  for (const auto i : points) {
    if (std::abs(plane.Distance(cloud.points[i])) <= distance_m) near.push_back(i);
  }
  return near;
}

std::size_t CountNear(const PointCloud& cloud, const Indices& points, const Plane& plane,
                      double distance_m) {
  return static_cast<std::size_t>(std::count_if(points.begin(), points.end(), [&](auto i) {
    return std::abs(plane.Distance(cloud.points[i])) <= distance_m;
  }));
}

Plane TurnedUp(const Plane& plane, const Eigen::Vector3d& up) {
  return plane.normal.dot(up) < 0.0 ? Plane{-plane.normal, -plane.offset_m} : plane;
}

/// Eq. 5.5 among planes that are themselves within the angle of the table; refitted.
std::optional<Plane> FullestPlane(const PointCloud& cloud, const Indices& candidates,
                                  const Eigen::Vector3d& up, const FeatureOptions& options,
                                  core::Rng& rng) {
  if (candidates.size() < 3) return std::nullopt;
  const double least_cosine = std::cos(options.top_normal_angle_rad);
  std::optional<Plane> best;
  std::size_t most = 0;
  for (int draw = 0; draw < options.plane_draws; ++draw) {
    const auto a = candidates[rng.Index(candidates.size())];
    const auto b = candidates[rng.Index(candidates.size())];
    const auto c = candidates[rng.Index(candidates.size())];
    const auto plane = geometry::PlaneThrough(cloud.points[a], cloud.points[b], cloud.points[c]);
    if (!plane || std::abs(plane->normal.dot(up)) < least_cosine) continue;
    const std::size_t count = CountNear(cloud, candidates, *plane, options.plane_distance_m);
    if (count > most) {
      most = count;
      best = plane;
    }
  }
  if (!best) return std::nullopt;
  const auto refit = geometry::FitPlane(
      geometry::Select(cloud.points, Near(cloud, candidates, *best, options.plane_distance_m)));
  if (refit && std::abs(refit->normal.dot(up)) >= least_cosine &&
      CountNear(cloud, candidates, *refit, options.plane_distance_m) >= most) {
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
                              const Plane& table, const FeatureOptions& options, core::Rng& rng) {
  Indices left = candidates;
  std::optional<Plane> top;
  double top_height = 0.0;
  std::size_t fullest = 0;
  for (int round = 0; round < 3; ++round) {
    const auto plane = FullestPlane(cloud, left, table.normal, options, rng);
    if (!plane) break;
    const Indices inliers = Near(cloud, left, *plane, options.plane_distance_m);
    const double share = static_cast<double>(inliers.size()) / static_cast<double>(fullest);
    if (inliers.size() < kLeastPlanePoints || (top && share < options.top_plane_share)) break;
    const double height = MeanHeight(cloud, inliers, table);
    if (!top || height > top_height + 2.0 * options.plane_distance_m) {
      top = plane;
      top_height = height;
    }
    if (round == 0) fullest = inliers.size();
    std::erase_if(left, [&](auto i) {
      return std::abs(plane->Distance(cloud.points[i])) <= 2.0 * options.plane_distance_m;
    });
  }
  return top;
}

/// Fills all that follows from the points, the plane and (for a ridge) the axis.
void Describe(const PointCloud& cloud, const std::optional<Eigen::Vector3d>& axis,
              const FeatureOptions& options, TopSurface& top) {
  const geometry::Points points = geometry::Select(cloud.points, top.points);
  top.center_C = geometry::Centroid(points);
  const PlanarFrame frame =
      MakePlanarFrame(top.plane, top.center_C, axis.value_or(Eigen::Vector3d::Zero()));
  const auto flat = Flatten(frame, points);
  const Rectangle box =
      axis ? RectangleAlong(flat, Eigen::Vector2d::UnitX()) : SmallestRectangle(flat);
  top.major_C = box.axis.x() * frame.u + box.axis.y() * frame.v;
  Eigen::Index largest = 0;
  top.major_C.cwiseAbs().maxCoeff(&largest);
  if (top.major_C[largest] < 0.0) top.major_C = -top.major_C;
  top.minor_C = top.plane.normal.cross(top.major_C);
  top.major_m = box.length_m;
  top.minor_m = box.width_m;
  top.rim = OuterRim(cloud, top.points, top.plane, options.rim_alpha_m);
}

double Quantile(std::vector<double> values, double share) {
  const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

/// The direction that the normals are most nearly square to, and the mean square of what remains.
std::pair<Eigen::Vector3d, double> CommonSquare(const PointCloud& cloud, const Indices& points) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto i : points) scatter += cloud.normals[i] * cloud.normals[i].transpose();
  scatter /= static_cast<double>(points.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  return {eigen.eigenvectors().col(0), eigen.eigenvalues()[0]};
}

double Correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  const auto n = static_cast<double>(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    sa += a[i];
    sb += b[i];
    saa += a[i] * a[i];
    sbb += b[i] * b[i];
    sab += a[i] * b[i];
  }
  const double variances = (n * saa - sa * sa) * (n * sbb - sb * sb);
  return variances > 0.0 ? (n * sab - sa * sb) / std::sqrt(variances) : 0.0;
}

/// Where the surface is level across the axis: u over sin(theta) fitted by a line, at theta = 0
/// (for a circle, an ellipse or a roof alike that is its highest line), and the line's slope: the
/// radius.
std::pair<double, double> LevelLine(const std::vector<double>& sines,
                                    const std::vector<double>& offsets) {
  double s = 0, u = 0, ss = 0, su = 0;
  const auto n = static_cast<double>(sines.size());
  for (std::size_t i = 0; i < sines.size(); ++i) {
    s += sines[i];
    u += offsets[i];
    ss += sines[i] * sines[i];
    su += sines[i] * offsets[i];
  }
  const double variance = n * ss - s * s;
  if (variance <= 1e-9 * n * n) return {u / n, 0.0};
  const double slope = (n * su - s * u) / variance;
  return {(u - slope * s) / n, slope};
}

/// How far points off the ridge have come down, over what the arc that their normals speak of would
/// give. About 1 for a circle, 0.5 and more for a flat ellipse; next to nothing for the lip of a
/// cup, which has normals to all sides at one height.
double DropOverArc(const PointCloud& cloud, const Indices& points,
                   const std::vector<double>& angles, const Eigen::Vector3d& origin,
                   const Eigen::Vector3d& normal, double ridge_m, double radius_m) {
  constexpr double kOff_rad = 0.45;
  double drop = 0.0;
  double arc = 0.0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (std::abs(angles[k]) < kOff_rad) continue;
    drop += ridge_m - (cloud.points[points[k]] - origin).dot(normal);
    arc += radius_m * (1.0 - std::cos(angles[k]));
  }
  return arc > 0.0 ? drop / arc : 1.0;
}

std::optional<TopSurface> RidgeTop(const PointCloud& cloud, const Indices& segment,
                                   const Ridge& ridge, const FeatureOptions& options) {
  TopSurface top;
  top.ridge = true;
  const Eigen::Vector3d lateral = ridge.axis.cross(ridge.normal);
  const double least = std::cos(options.ridge_half_angle_rad);
  for (const auto i : segment) {
    const Eigen::Vector3d across = cloud.normals[i] - cloud.normals[i].dot(ridge.axis) * ridge.axis;
    if (cloud.normals[i].dot(ridge.normal) >= least * across.norm() &&
        std::abs((cloud.points[i] - ridge.point).dot(ridge.normal)) <= kSlab_m) {
      top.points.push_back(i);
    }
  }
  if (top.points.size() < kLeastPlanePoints) return std::nullopt;
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
    if (table.Distance(cloud.points[i]) >= height - kSlab_m) top.points.push_back(i);
  }
  if (top.points.size() < 3) return std::nullopt;
  const Eigen::Vector3d mean = geometry::Centroid(geometry::Select(cloud.points, top.points));
  top.plane = {table.normal, -table.normal.dot(mean)};
  Describe(cloud, std::nullopt, options, top);
  if (top.major_m <= 0.0 || top.rim.size() < 3) return std::nullopt;
  top.ridge = top.major_m > kFoldElongation * top.minor_m;
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
  const std::size_t k = std::min<std::size_t>(4, heights.size() / 10);
  std::nth_element(heights.begin(), heights.begin() + static_cast<std::ptrdiff_t>(k), heights.end(),
                   std::greater<>());
  return heights[k];
}

double BaseHeight(const PointCloud& cloud, const Indices& points, const Plane& table) {
  return -TopHeight(cloud, points, {-table.normal, -table.offset_m});
}

Indices OuterRim(const PointCloud& cloud, const Indices& points, const Plane& plane,
                 double alpha_m) {
  if (points.empty()) return {};
  const auto flat = Flatten(MakePlanarFrame(plane, cloud.points[points.front()]),
                            geometry::Select(cloud.points, points));
  Indices rim;
  if (flat.size() >= 3) {
    for (const auto& loop : geometry::BuildAlphaShape2(flat, alpha_m).loops) {
      double twice_area = 0.0;
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const auto& a = flat[loop[i]];
        const auto& b = flat[loop[(i + 1) % loop.size()]];
        twice_area += a.x() * b.y() - a.y() * b.x();
      }
      if (twice_area <= 0.0) continue;  // A hole.
      for (const auto i : loop) rim.push_back(points[i]);
      break;
    }
  }
  if (rim.empty()) {
    for (const auto i : HullPositions(flat)) rim.push_back(points[i]);
  }
  return rim;
}

std::optional<Ridge> FindRidge(const PointCloud& cloud, const Indices& segment, const Plane& table,
                               const FeatureOptions& options) {
  // Wide enough for both sides of a roof of 60 deg, narrow enough to leave out walls.
  constexpr double kWindow_rad = 1.15;
  // Square to the axis within about 12 deg in the mean; spread of the middle 60 % of a plane's
  // normals about 10 deg with its rounded edges, of a lying cylinder's 45 deg and more.
  constexpr double kMostSquare = 0.045;
  constexpr double kLeastSpread_rad = 0.44;
  constexpr double kMostSlope = 0.5;
  constexpr double kLeastCorrelation = 0.7;
  constexpr double kLeastLengthShare = 0.6;
  constexpr double kLeastDropShare = 0.35;
  const Eigen::Vector3d& up = table.normal;
  Indices upward = UpwardPoints(cloud, segment, up, kWindow_rad);
  if (upward.size() < 2 * kLeastPlanePoints) return std::nullopt;
  Eigen::Vector3d axis = CommonSquare(cloud, upward).first;
  Indices square;
  for (const auto i : upward) {
    if (std::abs(cloud.normals[i].dot(axis)) < 0.35) square.push_back(i);
  }
  if (square.size() * 5 < upward.size() * 4) return std::nullopt;
  double rest = 0.0;
  std::tie(axis, rest) = CommonSquare(cloud, square);
  if (rest > kMostSquare || std::abs(axis.dot(up)) > kMostSlope) return std::nullopt;

  const Eigen::Vector3d normal = (up - up.dot(axis) * axis).normalized();
  const Eigen::Vector3d lateral = axis.cross(normal);
  std::vector<double> angles;
  for (const auto i : square) {
    angles.push_back(std::atan2(cloud.normals[i].dot(lateral), cloud.normals[i].dot(normal)));
  }
  if (Quantile(angles, 0.8) - Quantile(angles, 0.2) < kLeastSpread_rad) return std::nullopt;

  const Eigen::Vector3d origin = cloud.points[square.front()];
  std::vector<double> all_sines, all_offsets, all_along;
  for (std::size_t k = 0; k < square.size(); ++k) {
    all_sines.push_back(std::sin(angles[k]));
    all_offsets.push_back((cloud.points[square[k]] - origin).dot(lateral));
    all_along.push_back((cloud.points[square[k]] - origin).dot(axis));
  }
  // The near lip and the far wall of a cup both face the sensor; on a ridge the side tells.
  if (Correlation(all_sines, all_offsets) < kLeastCorrelation) return std::nullopt;

  std::vector<double> sines, offsets, heights, along;
  for (std::size_t k = 0; k < square.size(); ++k) {
    if (std::abs(angles[k]) > options.ridge_half_angle_rad) continue;
    sines.push_back(std::sin(angles[k]));
    offsets.push_back((cloud.points[square[k]] - origin).dot(lateral));
    heights.push_back((cloud.points[square[k]] - origin).dot(normal));
    along.push_back(all_along[k]);
  }
  if (sines.size() < kLeastPlanePoints) return std::nullopt;
  // A cap above a shoulder is not the shoulder's ridge.
  if (Quantile(along, 0.95) - Quantile(along, 0.05) <
      kLeastLengthShare * (Quantile(all_along, 0.95) - Quantile(all_along, 0.05))) {
    return std::nullopt;
  }
  const auto [u, radius] = LevelLine(sines, offsets);
  const double height = Quantile(heights, 0.8);
  // A flat top would ask for a drop that its edges are too near for.
  const double half_width = 0.5 * (Quantile(all_offsets, 0.98) - Quantile(all_offsets, 0.02));
  if (DropOverArc(cloud, square, angles, origin, normal, height, std::min(radius, half_width)) <
      kLeastDropShare) {
    return std::nullopt;
  }
  return Ridge{axis, normal, origin + u * lateral + height * normal};
}

std::optional<TopSurface> FindTopSurface(const PointCloud& cloud, const Indices& segment,
                                         const Plane& table, const FeatureOptions& options,
                                         core::Rng& rng) {
  if (segment.size() < 3) return std::nullopt;
  if (options.ridge_tops) {
    if (const auto ridge = FindRidge(cloud, segment, table, options)) {
      if (auto top = RidgeTop(cloud, segment, *ridge, options)) return top;
    }
  }
  const Indices candidates =
      UpwardPoints(cloud, segment, table.normal, options.top_normal_angle_rad);
  // Fewer than these are the rounding of an edge, not a surface.
  if (candidates.size() >= std::max(kLeastPlanePoints, segment.size() / 25)) {
    if (const auto plane = TopPlane(cloud, candidates, table, options, rng)) {
      TopSurface top;
      top.plane = *plane;
      top.points = Near(cloud, segment, *plane, options.plane_distance_m);
      Describe(cloud, std::nullopt, options, top);
      if (top.major_m > 0.0 && top.rim.size() >= 3) return top;
    }
  }
  return SlabTop(cloud, segment, table, options);
}

}  // namespace rangegrasp::perception
