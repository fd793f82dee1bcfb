#include "perception/internal/ridge.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "base/quantile.h"

namespace rangegrasp::perception::internal {
namespace {

using base::QuantileOf;
using geometry::Indices;
using geometry::PointCloud;

/// Ends of a length, and the height of a ridge, that a few stray points do not move: shares of the
/// points that may lie beyond.
constexpr double kEndShare = 0.05;
constexpr double kWidthEndShare = 0.02;
constexpr double kHeightShare = 0.8;
/// Both ends of the middle 60 % of the normals.
constexpr double kSpreadFrom = 0.2;
constexpr double kSpreadTo = 0.8;
/// A spread of sines below this (variance) is no spread: no slope can be had from it.
constexpr double kNoVariance = 1e-9;

double Between(const std::vector<double>& values, double from, double to) {
  return QuantileOf(values, to) - QuantileOf(values, from);
}

/// The direction that the normals are most nearly square to, and the mean square of what remains.
std::pair<Eigen::Vector3d, double> CommonSquare(const PointCloud& cloud, const Indices& points) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto i : points) scatter += cloud.normals[i] * cloud.normals[i].transpose();
  scatter /= static_cast<double>(points.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  return {eigen.eigenvectors().col(0), eigen.eigenvalues()[0]};
}

/// Sums over pairs of numbers.
struct Sums {
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;

  Sums(const std::vector<double>& xs, const std::vector<double>& ys)
      : n(static_cast<double>(xs.size())) {
    for (std::size_t i = 0; i < xs.size(); ++i) {
      x += xs[i];
      y += ys[i];
      xx += xs[i] * xs[i];
      yy += ys[i] * ys[i];
      xy += xs[i] * ys[i];
    }
  }
  double Correlation() const {
    const double variances = (n * xx - x * x) * (n * yy - y * y);
    return variances > 0.0 ? (n * xy - x * y) / std::sqrt(variances) : 0.0;
  }
  /// The least-squares line y = first + second x; a level one where the x are all alike.
  std::pair<double, double> Line() const {
    const double variance = n * xx - x * x;
    if (variance <= kNoVariance * n * n) return {y / n, 0.0};
    const double slope = (n * xy - x * y) / variance;
    return {(y - slope * x) / n, slope};
  }
};

/// The upward points of a segment about the axis that their normals are square to.
struct Body {
  Eigen::Vector3d axis;
  Eigen::Vector3d normal;   ///< square to the axis, as near to the table's as can be
  Eigen::Vector3d lateral;  ///< axis x normal
  Eigen::Vector3d origin;   ///< one of the points
  Indices points;
  std::vector<double> angles;   ///< of the normals about the axis, 0 along `normal`
  std::vector<double> sines;    ///< of the angles
  std::vector<double> offsets;  ///< along `lateral`
  std::vector<double> along;    ///< along the axis
  std::vector<double> heights;  ///< along `normal`
};

/// The axis and the points whose normals are square to it; nullopt if they are few or steep.
std::optional<Body> AboutOneAxis(const PointCloud& cloud, const Indices& segment,
                                 const Eigen::Vector3d& up, const FeatureOptions& options) {
  const Indices upward = UpwardPoints(cloud, segment, up, options.ridge.window_rad);
  // Each side of the ridge is a surface.
  if (upward.size() < 2 * static_cast<std::size_t>(options.top.min_plane_points)) {
    return std::nullopt;
  }
  Body body;
  body.axis = CommonSquare(cloud, upward).first;
  for (const auto i : upward) {
    if (std::abs(cloud.normals[i].dot(body.axis)) < options.ridge.max_along_axis) {
      body.points.push_back(i);
    }
  }
  if (static_cast<double>(body.points.size()) <
      options.ridge.min_square_share * static_cast<double>(upward.size())) {
    return std::nullopt;
  }
  double rest = 0.0;
  std::tie(body.axis, rest) = CommonSquare(cloud, body.points);
  if (rest > options.ridge.max_mean_square ||
      std::abs(body.axis.dot(up)) > options.ridge.max_axis_slope) {
    return std::nullopt;
  }
  return body;
}

void Measure(const PointCloud& cloud, const Eigen::Vector3d& up, Body& body) {
  body.normal = (up - up.dot(body.axis) * body.axis).normalized();
  body.lateral = body.axis.cross(body.normal);
  body.origin = cloud.points[body.points.front()];
  for (const auto i : body.points) {
    const Eigen::Vector3d& n = cloud.normals[i];
    const Eigen::Vector3d d = cloud.points[i] - body.origin;
    body.angles.push_back(std::atan2(n.dot(body.lateral), n.dot(body.normal)));
    body.sines.push_back(std::sin(body.angles.back()));
    body.offsets.push_back(d.dot(body.lateral));
    body.along.push_back(d.dot(body.axis));
    body.heights.push_back(d.dot(body.normal));
  }
}

/// The points about the ridge, as columns of their own.
Body Strip(const Body& body, double half_angle_rad) {
  Body strip;
  for (std::size_t k = 0; k < body.points.size(); ++k) {
    if (std::abs(body.angles[k]) > half_angle_rad) continue;
    strip.sines.push_back(body.sines[k]);
    strip.offsets.push_back(body.offsets[k]);
    strip.along.push_back(body.along[k]);
    strip.heights.push_back(body.heights[k]);
  }
  return strip;
}

/// How far points off the ridge have come down, over what the arc that their normals speak of would
/// give; 1 where none is off it.
double DropOverArc(const Body& body, double off_ridge_rad, double height_m, double radius_m) {
  double drop = 0.0;
  double arc = 0.0;
  for (std::size_t k = 0; k < body.points.size(); ++k) {
    if (std::abs(body.angles[k]) < off_ridge_rad) continue;
    drop += height_m - body.heights[k];
    arc += radius_m * (1.0 - std::cos(body.angles[k]));
  }
  return arc > 0.0 ? drop / arc : 1.0;
}

}  // namespace

Indices UpwardPoints(const PointCloud& cloud, const Indices& segment, const Eigen::Vector3d& up,
                     double angle_rad) {
  const double min_cosine = std::cos(angle_rad);
  Indices upward;
  for (const auto i : segment) {
    if (cloud.normals[i].dot(up) >= min_cosine) upward.push_back(i);
  }
  return upward;
}

std::optional<Ridge> FindRidge(const PointCloud& cloud, const Indices& segment,
                               const geometry::Plane& table, const FeatureOptions& options) {
  const RidgeOptions& asked = options.ridge;
  auto body = AboutOneAxis(cloud, segment, table.normal, options);
  if (!body) return std::nullopt;
  Measure(cloud, table.normal, *body);
  if (Between(body->angles, kSpreadFrom, kSpreadTo) < asked.min_spread_rad) return std::nullopt;
  if (Sums(body->sines, body->offsets).Correlation() < asked.min_correlation) return std::nullopt;

  const Body strip = Strip(*body, asked.half_angle_rad);
  if (strip.sines.size() < static_cast<std::size_t>(options.top.min_plane_points)) {
    return std::nullopt;
  }
  const auto length = [](const Body& b) { return Between(b.along, kEndShare, 1.0 - kEndShare); };
  if (length(strip) < asked.min_length_share * length(*body)) return std::nullopt;

  const auto [u, radius] = Sums(strip.sines, strip.offsets).Line();
  const double height = QuantileOf(strip.heights, kHeightShare);
  // A flat top would ask for a drop that its edges are too near for.
  const double half_width = 0.5 * Between(body->offsets, kWidthEndShare, 1.0 - kWidthEndShare);
  if (DropOverArc(*body, asked.off_ridge_rad, height, std::min(radius, half_width)) <
      asked.min_drop_share) {
    return std::nullopt;
  }
  return Ridge{body->axis, body->normal, body->origin + u * body->lateral + height * body->normal};
}

}  // namespace rangegrasp::perception::internal
