#pragma once

namespace rangegrasp::perception {

/// Options of sections 5.1.3 and 5.1.4 and of the open/closed test of section 5.2. Where a default
/// goes beyond the dissertation the comment gives the reason.
struct FeatureOptions {
  // Top surface (eq. 5.5).
  int plane_draws = 100;
  double plane_distance_m = 0.002;
  /// A point may be of the top surface if its normal is within this of the table's.
  double top_normal_angle_rad = 0.785;
  /// The highest plane that holds this share of the fullest one's points is the top; 1: eq. 5.5 as
  /// published. The floor of a container, or a shoulder, can hold more points than the rim above.
  double top_plane_share = 0.3;
  /// Where the highest part curves about a lying axis, take the strip along its ridge: every plane
  /// touching a lying cylinder holds about as many points, so eq. 5.5 alone would tip at random.
  bool ridge_tops = true;
  double ridge_half_angle_rad = 0.35;  ///< of the strip's normals about the ridge's
  double rim_alpha_m = 0.006;          ///< of the 2-D alpha shape
  /// The second try of a rim whose ring has gaps (lost points) of up to twice this.
  double bridged_rim_alpha_m = 0.030;

  // Circles and rotation axes (eq. 5.6 to 5.8).
  int circle_draws = 100;
  double circle_distance_m = 0.002;  ///< eq. 5.6
  double rim_share = 0.8;            ///< of the rim points on one circle
  double body_share = 0.8;           ///< of the points that agree with their section
  double section_m = 0.004;          ///< thickness of the section planes along the axis
  /// A short arc fits nearly any curve: the rim has to go this far round, and a circle wider than
  /// the next bound is no tabletop object's.
  double least_arc_rad = 2.1;
  /// The same for a rim with bridged gaps, whose straight sides count for few points.
  double least_bridged_arc_rad = 4.2;
  double most_radius_m = 0.15;
  /// Where the top is a thin ring, find the axis from the body's normals instead of the rim's
  /// circle, and merge clipped parts by it: the lip of a cup is as wide as the profiles are apart,
  /// so its rim has too few points. Off: as published.
  bool axis_from_body = true;
  double ring_share = 0.35;  ///< a top is a thin ring if it fills less than this of its circle
  /// In the place of body_share there: a handle in front of the body and normals at its edges count
  /// against it, while the ring already is the better witness.
  double ring_body_share = 0.6;

  // Merging.
  /// Joins parts of one object that lost points have separated (see merge.h); off: only clipped
  /// rotational parts are merged, as published.
  bool merge_fragments = true;
  double fragment_gap_m = 0.012;  ///< the widest gap that is taken for lost points

  // Completion (section 5.1.4).
  double completion_step_rad = 0.0872665;  ///< 5 deg
  /// Mirrors what is seen of ridges and of bodies wider than their tops into space that the sensor
  /// did not see through. Without it the far half of a lying cylinder is missing and a hand that
  /// closes on the seen half meets the other.
  bool complete_by_symmetry = true;
  double mirror_share = 0.85;  ///< of the mirrored points that must be in unseen space

  /// A part whose footprint is nowhere this long is a needle of mixed points along one ray, not an
  /// object. 0: as published.
  double least_footprint_m = 0.015;

  // Open or closed (eq. 5.9).
  double open_sphere_factor = 2.0 / 3.0;
  /// Points inside the sphere that are still taken for none, as a share of the top surface's: mixed
  /// points hang between the near rim and the far wall. 0: as published.
  double open_stray_share = 0.02;
};

}  // namespace rangegrasp::perception
