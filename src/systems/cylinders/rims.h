#pragma once

#include "base/units.h"
#include "perception/sampling.h"

/// Curvature points: where a surface bends or ends (section 4.2.3).

namespace rangegrasp::cylinders {

/// cos(beta_i) of eq. 4.14, the angle at p between the directions to the previous and the next
/// point on its scan line: -1 on a straight line, and also if two of the points coincide.
double EdgeCosine(const Eigen::Vector3d& before, const Eigen::Vector3d& p,
                  const Eigen::Vector3d& after);

/// The axes of the sensor's frame S as columns. x points up, as for the cylinder with v = (1, 0, 0)
/// in section 4.4; z is horizontal and points towards the sensor, or n_x > n_z would exclude
/// nothing.
Eigen::Matrix3d SensorAxes(const Eigen::Vector3d& up, const Eigen::Vector3d& to_sensor);

/// n_x > n_y and n_x > n_z of a normal in the sensor's frame (section 4.2.4). Signed components, as
/// printed: a normal towards -y passes for any n_x > 0.
inline bool PassesSensorGate(const Eigen::Vector3d& n_S) {
  return n_S.x() > n_S.y() && n_S.x() > n_S.z();
}

struct CurvatureOptions {
  /// Neighborhood of a point (section 4.2.3): the same as for its normal.
  perception::AdaptiveLength radius_m{0.005, {.noises = 5.0, .spacings = 1.7}};
  double min_angle_rad = base::Deg(20.0);        ///< alpha (section 4.2.3)
  double max_edge_angle_rad = base::Deg(110.0);  ///< beta (section 4.2.3)
  /// Distance on the scan line over which an edge's angle is measured. 0: to the previous and next
  /// stored points ("line by line", section 4.2.3), so that lines end in edges. They are 2 mm apart
  /// there; at distances below the noise every point would be an edge.
  perception::AdaptiveLength line_step_m{0.002, {.noises = 8.0}};
  /// Maximum angle of a top's normal to the table's. Larger: more of a rim's outside.
  double max_tilt_rad = base::Deg(55.0);
};

/// For each point, whether the angle of its normal to its m neighbors' is above min_angle_rad; its
/// cosine is the mean of their cosines (eq. 4.13; the printed sum lacks 1 / m). O(n log n).
/// @param known  neighbors found by the normal estimation; used if their radius is options.radius_m
std::vector<bool> CurvedPoints(const geometry::PointCloud& cloud, const geometry::KdTree& tree,
                               const CurvatureOptions& options,
                               const geometry::NeighborLists& known = {});

/// For each point, whether its scan line has an edge there (eq. 4.14). Points are in scan order.
/// @param lines  the number of each point's scan line. O(n).
std::vector<bool> LineEdges(geometry::PointSpan points, std::span<const std::uint32_t> lines,
                            const CurvatureOptions& options);

// Segmentation of curvature points into connected fragments (section 4.2.3).

/// d_ca of eq. 4.15 [m]: the mean distance of a point to its m neighbors within radius_m (those of
/// eq. 4.13), averaged over all points that have neighbors; 0 if none has any.
double MeanNeighborDistance(geometry::PointSpan points, const geometry::KdTree& tree,
                            double radius_m);

struct FragmentOptions {
  /// Distance below which points are linked, in mean nearest-neighbor distances (one reading of
  /// d_ca; at 1 about half of all points would be isolated). 0: d_ca, as published (eq. 4.17).
  /// Larger: fragments with gaps stay connected, but so do those of touching objects.
  double link = 3.0;
  double neighborhood_m = 0.005;  ///< neighborhood of d_ca (section 4.2.3)
  int min_points = 12;            ///< fewer points do not determine a circle
};

/// Connected sets of points, each closer than the link to another of its set (eq. 4.16, 4.17): the
/// same as the recursive flood fill, by disjoint sets. Largest first, ties by first point;
/// positions ascending; sets with fewer than min_points left out. O(n log n).
std::vector<geometry::Indices> Fragments(geometry::PointSpan points,
                                         const FragmentOptions& options);

// Random circle fitting (RCF), the dissertation's fit of a rim (section 4.2.4).

/// A circle in the frame of the points that it was fitted to.
struct Circle {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();   ///< c_m [m]
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit; sign arbitrary
  double radius_m = 0.0;
};

/// Dot and pair products of the sides of the triangle A, B, C (eq. 4.18, 4.19) [m^2, m^4].
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
/// n_3), i.e. |AB| |BC| |CA| / (4 area). With the root over the product alone it would be in 1 / m.
double CircumradiusOf(const TriangleProducts& products);

/// The circumcircle of the triangle a, b, c (eq. 4.18 to 4.21); nullopt if they are collinear.
std::optional<Circle> CircleThrough(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c);

enum class CircleDistance {
  kSphere,  ///< | ||p - c_m|| - r | of eq. 4.26: from the sphere of radius r about c_m
  kCurve,   ///< from the circumference, including the distance from the circle's plane
};
/// Distance [m] of p from the circle.
double DistanceTo(const Circle& circle, const Eigen::Vector3d& p, CircleDistance distance);

/// d_j of eq. 4.24 [m]: the sum of all points' distances "to the circumference". (|r - p_c| in the
/// equation subtracts a point from a number.) Stops early with a value above `enough_m`.
double SumOfDistances(const Circle& circle, geometry::PointSpan rim, double enough_m);

/// Share of the points for which eq. 4.26 holds; 0 if there are none.
double ShareOn(const Circle& circle, geometry::PointSpan rim, CircleDistance distance,
               double tolerance_m);

/// The circle through a randomly drawn triple with the least sum of distances of all points (RCF,
/// eq. 4.24, 4.25, section 4.2.4). O(draws n).
/// @return nullopt if there are fewer than three points or no triple gave a circle.
/// @param draws  >= 1; 100 as published
std::optional<Circle> FitRandomCircle(geometry::PointSpan rim, int draws, base::Rng& rng);

}  // namespace rangegrasp::cylinders
