#pragma once

#include "base/units.h"
#include "cylinders/cylinder.h"
#include "perception/sampling.h"

/// Barrel of a cylinder whose axis is approximately known: its points, its pose and its ends.

namespace rangegrasp::cylinders {

struct BarrelOptions {
  /// Maximum distance of a barrel point from the surface ("threshold of 2 mm", section 4.2.4).
  perception::AdaptiveLength distance_m{0.002, {.noises = 3.0}};
  /// The same before the axis is refined: it covers the error of a candidate's axis at its ends.
  perception::AdaptiveLength first_distance_m{0.006, {.noises = 5.0}};
  /// Normals further from the radial direction belong to a neighbor, an end or an edge. Larger:
  /// more points at the outline, whose normals turn toward the sensor.
  double max_normal_angle_rad = base::Deg(30.0);
  int min_points = 24;  ///< fewer points do not determine an axis
  int rounds = 6;       ///< rounds of fitting and gathering points
  /// Length of the pieces along the axis by which the ends are found: one row of points each.
  perception::AdaptiveLength piece_m{0.003, {.noises = 2.0, .gaps = 1.2}};
  /// A piece with less than this share of the median piece's points is beyond the barrel's end.
  double min_piece_share = 0.25;
  /// Maximum angle between the axis and the normals of an end face (min_face_points or more).
  double max_face_angle_rad = base::Deg(30.0);
  int min_face_points = 12;
};

/// The points within distance_m of the surface about the axis, and between low_m and high_m along
/// it from its point: "along the circle axis" (section 4.2.4).
geometry::Indices BarrelPoints(geometry::PointSpan points, const Line& axis, double radius_m,
                               double low_m, double high_m, double distance_m);

/// An axis fitted to the points of a barrel.
struct RefinedAxis {
  Line axis;                 ///< fitted with the given radius
  double radius_m = 0.0;     ///< fitted together with the axis
  double radius_sd_m = 0.0;  ///< its standard deviation from the residuals: large for short arcs
  double arc_rad = 0.0;      ///< angle around the axis that the points cover without a gap
  /// Median angle between normals and radial direction: noise on a barrel, more on two box faces.
  double normal_angle_rad = 0.0;
  geometry::Indices points;  ///< points of the barrel
};

/// Alternately gathers points near the surface with radial normals, and minimizes the sum of their
/// squared distances by Gauss-Newton over the four degrees of freedom of the axis, with Tukey's
/// weights. The radius is fixed because on a short arc it would trade off against the distance to
/// the axis; it is fitted separately, only to be reported. O(rounds n).
/// @param near  positions of the points that may belong to the barrel
/// @return nullopt if there are too few points or they do not determine the axis.
std::optional<RefinedAxis> RefineAxis(const geometry::PointCloud& cloud,
                                      std::span<const std::uint32_t> near, const Line& start,
                                      double radius_m, const BarrelOptions& options);

/// The ends of a barrel, as positions along its axis from the axis' point [m].
struct BarrelEnds {
  double low_m = 0.0;
  double high_m = 0.0;
  bool low_face = false;  ///< the end was seen as a face, which gives its position
  bool high_face = false;

  double Length() const { return high_m - low_m; }
};

/// Finds the ends from the runs of well-filled pieces along the axis, and from visible end faces.
/// To the fullest run, others are joined up to max_length_m in total: an object may hide the
/// barrel's middle. O(n).
/// @param near  as for RefineAxis; end faces are searched among these points
std::optional<BarrelEnds> FindEnds(const geometry::PointCloud& cloud,
                                   std::span<const std::uint32_t> near, const RefinedAxis& refined,
                                   double radius_m, double max_length_m,
                                   const BarrelOptions& options);

// Search for barrels of a known radius, without their rims.

struct BarrelSearchOptions {
  /// Number of points used, evenly sampled. More: smaller parts of a barrel are found, but slower.
  int points = 6000;
  /// Scatter of the axis points (p - n r) about the axis: the normals' error of about 5 deg times
  /// the radius, but at least this.
  perception::AdaptiveLength min_scatter_m{0.002, {.noises = 3.0}};
  double scatter_of_radius = 0.09;
  /// Maximum deviation of a barrel's normal from the plane perpendicular to the axis.
  double max_off_square_rad = base::Deg(20.0);
  int max_standing = 12;  ///< candidates for each radius
  int max_lying = 6;
  int draws = 150;  ///< draws of a point; its normal gives the direction of a lying axis
  /// A lying barrel's normal must lean this far from the vertical to determine the axis' direction.
  double min_lean_rad = base::Deg(20.0);
  /// Oblique axes are drawn from pair_draws pairs: a line through two axis points that is
  /// perpendicular to both normals. A barrel with a twentieth of the points is drawn five times.
  int max_leaning = 3;
  int pair_draws = 2000;
  int pair_points = 2500;  ///< points used; each plausible pair is tested against all of them
  /// Axes closer than this to vertical or horizontal are left to the searches for those.
  double min_oblique_rad = base::Deg(10.0);
  int min_support = 12;  ///< minimum number of the used points that support a candidate
};

/// Axes near which many points p with normals n have their p - n r: on a barrel these all lie on
/// its axis. Returns standing axes (along `up`), then lying (perpendicular to it) and oblique ones,
/// each best supported first. O(n + points (draws + log points)).
/// @param up  unit vector, away from the table
std::vector<Line> FindBarrels(const geometry::PointCloud& cloud, const Eigen::Vector3d& up,
                              double radius_m, double height_m, const BarrelSearchOptions& options,
                              base::Rng& rng);

}  // namespace rangegrasp::cylinders
