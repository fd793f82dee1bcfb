#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/rng.h"
#include "base/units.h"
#include "cylinders/cylinder.h"
#include "geometry/point_cloud.h"
#include "perception/sampling.h"

/// The barrel of a cylinder whose axis is about known: its points, the pose that they say, and its
/// ends.

namespace rangegrasp::cylinders {

struct BarrelOptions {
  /// Of a point of the barrel from the surface (section 4.2.4, "threshold of 2 mm").
  perception::AdaptiveLength distance_m{0.002, {.noises = 3.0}};
  /// Before the axis was refined: what a candidate's axis may be off at its ends.
  perception::AdaptiveLength first_distance_m{0.006, {.noises = 5.0}};
  /// A normal further from the radial is of a neighbor, an end or an edge. Larger: more of the
  /// outline, whose normals turn to the sensor.
  double max_normal_angle_rad = base::Deg(30.0);
  int min_points = 24;  ///< fewer say nothing about an axis
  int rounds = 6;       ///< of fitting and gathering
  /// The barrel is cut into pieces along its axis to see where it ends: a row of points each.
  perception::AdaptiveLength piece_m{0.003, {.noises = 2.0, .gaps = 1.2}};
  /// A piece with less than this share of the median piece's points is beyond the barrel's end.
  double min_piece_share = 0.25;
  /// A normal within this of the axis is of an end's face, which has so many points.
  double max_face_angle_rad = base::Deg(30.0);
  int min_face_points = 12;
};

/// The points within distance_m of the surface of radius radius_m about the axis, and from low_m to
/// high_m along it from its point: all that "along the circle axis" asks (section 4.2.4).
geometry::Indices BarrelPoints(geometry::PointSpan points, const Line& axis, double radius_m,
                               double low_m, double high_m, double distance_m);

/// What the points of a barrel say of its axis.
struct RefinedAxis {
  Line axis;                 ///< fitted with the given radius
  double radius_m = 0.0;     ///< fitted together with the axis
  double radius_sd_m = 0.0;  ///< its standard deviation by the residuals: large for short arcs
  double rms_m = 0.0;        ///< of the residuals about the given radius
  double arc_rad = 0.0;      ///< how far round the axis the points go without a gap
  /// Median, of the normals from the radial: noise on a barrel, more on two faces of a box.
  double normal_angle_rad = 0.0;
  geometry::Indices points;  ///< of the barrel
};

/// In turn gathers points near the surface with radial normals, and minimises the sum of their
/// squared distances by Gauss-Newton over the axis' four degrees of freedom, with Tukey's weights.
/// With the radius known, the distance to the axis does not trade against it, as it does on a short
/// arc; the radius is fitted separately, to be reported. O(rounds n).
/// @param near  positions of the points that may be of the barrel
/// @return nullopt if there are too few or they say nothing of an axis.
std::optional<RefinedAxis> RefineAxis(const geometry::PointCloud& cloud,
                                      std::span<const std::uint32_t> near, const Line& start,
                                      double radius_m, const BarrelOptions& options);

/// Where a barrel ends, along its axis from the axis' point [m].
struct BarrelEnds {
  double low_m = 0.0;
  double high_m = 0.0;
  bool low_face = false;  ///< the end was seen as a face, which says where it is
  bool high_face = false;

  double Length() const { return high_m - low_m; }
};

/// From the runs of well-filled pieces along the axis, and the ends' faces where they are seen. The
/// fullest run is of the barrel, and others next to it as long as all are no longer than
/// max_length_m: something may stand in front of the middle, or continue the barrel. O(n).
/// @param near  as of RefineAxis: faces are looked for among them
std::optional<BarrelEnds> FindEnds(const geometry::PointCloud& cloud,
                                   std::span<const std::uint32_t> near, const RefinedAxis& refined,
                                   double radius_m, double max_length_m,
                                   const BarrelOptions& options);

// Barrels of a known radius, without their rims.

struct BarrelSearchOptions {
  /// Points that are looked at, evenly taken. More: smaller parts of a barrel are found, slower.
  int points = 6000;
  /// How far axis points (p - n r) scatter about the axis: the normals' error of about 5 deg times
  /// the radius, and at least this.
  perception::AdaptiveLength min_scatter_m{0.002, {.noises = 3.0}};
  double scatter_of_radius = 0.09;
  /// A normal within this of square to the axis may be of the barrel.
  double max_off_square_rad = base::Deg(20.0);
  int max_standing = 12;  ///< of each radius
  int max_lying = 6;
  int draws = 150;  ///< of points whose normal gives the direction of a lying axis
  /// A lying barrel's normal must lean this far from the vertical to determine the axis' direction.
  double min_lean_rad = base::Deg(20.0);
  /// From so many draws of pairs: a line through two axis points that is square to both normals. A
  /// barrel with a twentieth of the points is drawn five times.
  int max_leaning = 3;
  int pair_draws = 2000;
  int pair_points = 2500;  ///< of those looked at: every pair that may be asks all of them
  /// An axis within this of upright or of level is left to the searches for those.
  double min_oblique_rad = base::Deg(10.0);
  int min_support = 12;  ///< of a candidate, of the points looked at
};

/// Axes that many points p with normals n have their p - n r about, which on a barrel of radius r
/// are all on its axis: of standing (along `up`), lying (square to it) and leaning ones, best
/// supported first within each. Given cylinders of nearly one radius find each other's. O(n +
/// points (draws + log points)).
/// @param up  unit, away from the table
/// @throws std::invalid_argument if there is not one normal a point.
std::vector<Line> FindBarrels(const geometry::PointCloud& cloud, const Eigen::Vector3d& up,
                              double radius_m, double height_m, const BarrelSearchOptions& options,
                              base::Rng& rng);

}  // namespace rangegrasp::cylinders
