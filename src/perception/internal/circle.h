#pragma once

#include <optional>

#include "base/rng.h"
#include "geometry/point_cloud.h"
#include "perception/feature_options.h"

namespace rangegrasp::perception::internal {

/// A circle in the frame of the points it came from.
struct Circle {
  Eigen::Vector3d center;
  Eigen::Vector3d normal;  ///< unit; sign arbitrary
  double radius_m = 0.0;
};

/// The circle through three points; nullopt if they are collinear. With u = b - a, v = c - a,
/// w = u x v its centre is a + (|u|^2 v x w + |v|^2 w x u) / (2 |w|^2), which is what eq. 4.18 to
/// 4.21 give.
std::optional<Circle> CircleThrough(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c);

struct CircleFit {
  Circle circle;
  geometry::Indices inliers;  ///< ascending positions in the given points
};

/// Distance [m] of p from the curve: the larger of | |q - c| - r | (eq. 5.6, q in the circle's
/// plane) and of p's distance from that plane.
double CircleDistance(const Circle& circle, const Eigen::Vector3d& p);

/// 3-D circle by RANSAC over 3-point samples: most points with CircleDistance <= the options'
/// distance wins (eq. 5.6, 5.7), then least-squares refits to the inliers. O(draws * n).
/// @return nullopt if no draw gave a circle of an admissible radius.
std::optional<CircleFit> FitCircle(geometry::PointSpan rim, const CircleFitOptions& options,
                                   base::Rng& rng);

/// How far round the circle's axis the points go [rad], counted in bins of 10 deg.
double ArcOf(const geometry::PointCloud& cloud, const geometry::Indices& points,
             const Circle& circle);

/// Distance [m] of p from the axis through c with unit direction n: |(p - c) x n| (eq. 5.8).
double AxisDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& c, const Eigen::Vector3d& n);

/// The least-squares circle of points in the plane (algebraic, Kasa): centre and radius; nullopt if
/// they are collinear or fewer than three.
struct Circle2 {
  Eigen::Vector2d center;
  double radius_m = 0.0;
};
std::optional<Circle2> FitCircle2(std::span<const Eigen::Vector2d> points);

}  // namespace rangegrasp::perception::internal
