#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "base/rng.h"
#include "geometry/point_cloud.h"

/// Random circle fitting, the dissertation's fit of a rim (section 4.2.4).
namespace rangegrasp::cylinders {

/// A circle in the frame of the points it came from.
struct Circle {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();   ///< c_m [m]
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit; sign arbitrary
  double radius_m = 0.0;
};

/// The products of the sides of the triangle A, B, C (eq. 4.18, 4.19) [m^2, m^4].
struct TriangleProducts {
  double d_ca = 0.0;  ///< (C - A) . (B - A); the text calls it d_ac in eq. 4.19
  double d_ba = 0.0;  ///< (C - B) . (A - B)
  double d_cb = 0.0;  ///< (A - C) . (B - C)
  double n_1 = 0.0;   ///< d_ba d_cb
  double n_2 = 0.0;   ///< d_cb d_ca
  double n_3 = 0.0;   ///< d_ca d_ba

  /// n_1 + n_2 + n_3: the square of twice the triangle's area.
  double Sum() const { return n_1 + n_2 + n_3; }
};
TriangleProducts ProductsOf(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c);

/// r of eq. 4.20 [m]: half of the root of (d_ca + d_ba)(d_ba + d_cb)(d_cb + d_ca) / (n_1 + n_2 +
/// n_3). The root is over the quotient: with the root over the product of the sides alone r would
/// be 1 / m. Each factor is a squared side, so that r = |AB| |BC| |CA| / (4 area).
double CircumradiusOf(const TriangleProducts& products);

/// The circle round the triangle a, b, c (eq. 4.18 to 4.21); nullopt if they are collinear.
std::optional<Circle> CircleThrough(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c);

/// Area [m^2] and circumference [m] of a circle (eq. 4.22, 4.23; the text says "triangle area").
double AreaOf(const Circle& circle);
double CircumferenceOf(const Circle& circle);

/// What a point's distance from a circle is.
enum class CircleDistance {
  kSphere,  ///< | ||p - c_m|| - r |, as eq. 4.24 and 4.26 have it: from the sphere round the circle
  kCurve,   ///< from the curve itself: what lies on the sphere but off the circle's plane is off
};
constexpr std::array<std::string_view, 2> WordsOf(CircleDistance) { return {"sphere", "curve"}; }

/// Distance [m] of p from the circle.
double DistanceTo(const Circle& circle, const Eigen::Vector3d& p, CircleDistance distance);

/// d_j of eq. 4.24 [m]: the sum of all distances. The text's |r - p_c| is read as | r - ||p_c -
/// c_m|| |, as eq. 4.26 writes it. Ends early with a value above `enough_m`.
double SumOfDistances(const Circle& circle, geometry::PointSpan rim, CircleDistance distance,
                      double enough_m);

/// Share of the points for which eq. 4.26 holds; 0 if there are none.
double ShareOn(const Circle& circle, geometry::PointSpan rim, CircleDistance distance,
               double tolerance_m);

struct RandomCircleOptions {
  int draws = 100;  ///< >= 1 (section 4.2.4)
  CircleDistance distance = CircleDistance::kSphere;
};

/// The circle of the triple with the least sum of distances of all draws (eq. 4.24, 4.25).
struct RandomCircle {
  Circle circle;
  double sum_m = 0.0;  ///< its d_j
  int drawn = 0;       ///< triples that made a circle
};

/// Draws triples of the points and takes the circle that all points are nearest to (RCF, section
/// 4.2.4). O(draws n), and less where a draw's sum exceeds the best before its end. Depends only on
/// the arguments and the rng's state.
/// @return nullopt if there are fewer than three points or no triple made a circle.
/// @throws std::invalid_argument if draws < 1.
std::optional<RandomCircle> FitRandomCircle(geometry::PointSpan rim,
                                            const RandomCircleOptions& options, base::Rng& rng);

}  // namespace rangegrasp::cylinders
