#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "base/units.h"
#include "cylinders/axis_fit.h"
#include "geometry/point_cloud.h"
#include "perception/sampling.h"

/// The barrel of a cylinder whose axis is about known: its points, the pose that they say, and its
/// ends.
namespace rangegrasp::cylinders {

struct BarrelOptions {
  /// Of a point of the barrel from the surface (section 4.2.4, "threshold of 2 mm").
  perception::AdaptiveLength distance_m{0.002, {.noises = 3.0}};
  /// The same before the axis was refined: what a candidate's axis may be off at its ends.
  perception::AdaptiveLength first_distance_m{0.006, {.noises = 5.0}};
  /// A point whose normal is further from the radial is of a neighbor that touches, of an end or of
  /// an edge. Larger: more of the outline, whose normals turn to the sensor.
  double max_normal_angle_rad = base::Deg(30.0);
  /// Fewer points say nothing about an axis.
  int min_points = 24;
  /// Of fitting and gathering; each costs a pass over the points near the barrel.
  int rounds = 6;
  /// Length of the pieces that the barrel is cut into along its axis to see where it ends: one row
  /// of points at least.
  perception::AdaptiveLength piece_m{0.003, {.noises = 2.0, .gaps = 1.2}};
  /// A piece with less than this share of the median piece's points is beyond the barrel's end.
  double min_piece_share = 0.25;
  /// A normal within this of the axis is of an end (its face).
  double max_face_angle_rad = base::Deg(30.0);
  /// An end's face needs so many points.
  int min_face_points = 12;
};

/// The points within distance_m of the surface of radius radius_m about the axis, and from low_m to
/// high_m along it from its point: all that "along the circle axis" asks (section 4.2.4).
geometry::Indices BarrelPoints(geometry::PointSpan points, const Line& axis, double radius_m,
                               double low_m, double high_m, double distance_m);

/// What the points of a barrel say of its axis.
struct RefinedAxis {
  Line axis;                 ///< fitted with the given radius
  double radius_m = 0.0;     ///< fitted beside the axis
  double radius_sd_m = 0.0;  ///< its standard deviation by the residuals: large for short arcs
  double rms_m = 0.0;        ///< of the residuals about the given radius
  double arc_rad = 0.0;      ///< how far round the axis the points go without a gap
  /// Median angle of the points' normals from the radial: noise on a barrel; on two faces of a box
  /// about as near to the axis it is a quarter of what each goes round.
  double normal_angle_rad = 0.0;
  geometry::Indices points;  ///< of the barrel
};

/// The axis of the cylinder of the given radius nearest to the points in turn: those near the
/// surface whose normals are radial are gathered, and the sum of their squared distances made
/// least by Gauss-Newton (the axis has four degrees of freedom), with less weight to what is
/// further off (Tukey's). With the radius known, the distance to the axis does not trade against
/// it, as it does where the arc that is seen is short; the radius is fitted apart to be told.
/// O(rounds n).
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

/// From the runs of well-filled pieces along the axis, and the faces of the ends where they are
/// seen. The run with the most points is of the barrel, and others beside it as long as all are no
/// longer than max_length_m: something may stand in front of the middle, and what lies in the
/// barrel's continuation has points about the same axis, too. O(n).
/// @param near  as of RefineAxis: faces are looked for among them, too
std::optional<BarrelEnds> FindEnds(const geometry::PointCloud& cloud,
                                   std::span<const std::uint32_t> near, const RefinedAxis& refined,
                                   double radius_m, double max_length_m,
                                   const BarrelOptions& options);

}  // namespace rangegrasp::cylinders
