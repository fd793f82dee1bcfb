#pragma once

#include <vector>

#include "base/rng.h"
#include "base/units.h"
#include "cylinders/axis_fit.h"
#include "geometry/point_cloud.h"
#include "perception/sampling.h"

/// Barrels of a known radius, without their rims.
namespace rangegrasp::cylinders {

struct BarrelSearchOptions {
  /// Points that are looked at, evenly taken. More: smaller parts of a barrel are found; the time
  /// grows with them.
  int points = 6000;
  /// How far axis points (p - n r) scatter about the axis: by the normals' error of about 5 deg
  /// times the radius, and at least this.
  perception::AdaptiveLength min_scatter_m{0.002, {.noises = 3.0}};
  double scatter_of_radius = 0.09;
  /// A normal within this of square to the axis may be of the barrel.
  double max_off_square_rad = base::Deg(20.0);
  /// Standing and lying barrels that are looked for, of each radius.
  int max_standing = 12;
  int max_lying = 6;
  int draws = 150;  ///< of points whose normal gives the direction of a lying axis
  /// A lying barrel's normal must lean this far from the vertical to tell the axis' direction.
  double min_lean_rad = base::Deg(20.0);
  /// Leaning ones, of each radius, from so many draws of pairs: a line through two axis points that
  /// is square to both normals. A barrel with a twentieth of the points is drawn five times.
  int max_leaning = 3;
  int pair_draws = 2000;
  int pair_points = 2500;  ///< of those looked at: every pair that may be asks all of them
  /// An axis within this of upright or of level is left to the searches for those.
  double min_oblique_rad = base::Deg(10.0);
  /// Support of a candidate, of the points looked at, is at least this many.
  int min_support = 12;
};

/// Axes that many points p with normals n have their p - n r about: of standing barrels (along
/// `up`) of lying ones (square to it) and of leaning ones, best supported first within each. On a
/// barrel of radius r all of these are on its axis; on a plane they are a plane, on another barrel
/// a thinner one, so that few fall together. Two given cylinders of nearly one radius find each
/// other's. O(n + points (draws + log points)).
/// @param up  unit, away from the table
/// @throws std::invalid_argument if there is not one normal a point.
std::vector<Line> FindBarrels(const geometry::PointCloud& cloud, const Eigen::Vector3d& up,
                              double radius_m, double height_m, const BarrelSearchOptions& options,
                              base::Rng& rng);

}  // namespace rangegrasp::cylinders
