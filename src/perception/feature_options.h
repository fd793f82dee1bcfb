#pragma once

#include "base/units.h"
#include "perception/additions.h"
#include "perception/sampling.h"

namespace rangegrasp::perception {

// Defaults that stand in the dissertation name their equation or section. The others are this
// program's own; their comments say what they trade off. An AdaptiveLength stands for noise or
// spacing and says how much of it; all other lengths are an object's or a hand's and stay.

/// Top surfaces (section 5.1.3, eq. 5.5) and their rims.
struct TopSurfaceOptions {
  int plane_draws = 100;  ///< eq. 5.5
  AdaptiveLength plane_distance_m{
      0.002, {.noises = 2.5}};  ///< of a plane's points: as of the table's (section 5.1.1)
  /// A point may be of the top surface if its normal is within this (45 deg) of the table's: its
  /// main component is along the table's normal (section 5.1.3).
  double normal_angle_rad = 0.785;
  /// A plane with fewer points is no surface: three rows of four. Larger: small lids are lost.
  int min_plane_points = 12;
  /// Fewer upward points, as a share of the part's, are the rounding of an edge, not a surface.
  double min_upward_share = 0.04;
  /// Planes that are looked at for one above the fullest: a lip, a shoulder, a floor.
  int planes = 3;
  /// Two planes are two if they are this many plane distances apart: each holds the points within
  /// one of its own.
  double plane_separation = 2.0;
  /// Depth of the highest points that stand in for a plane: what a plane's inliers span.
  AdaptiveLength slab_m{0.004, {.noises = 5.0, .spacings = 1.35}};
  /// A slab this many times as long as wide is a fold; less is the lip of something.
  double fold_elongation = 4.0;
  /// alpha of the 2-D alpha shape of the rim: three point spacings. Smaller: holes between points;
  /// larger: the mouth of a cup closes.
  AdaptiveLength rim_alpha_m{0.006, {.noises = 3.0, .gaps = 1.3}};
  /// The second try of a rim whose ring has gaps (lost points) of up to twice this.
  AdaptiveLength bridged_rim_alpha_m{0.030, {.gaps = 6.5}};
};

/// How a ridge is told from a plane, the lip of a cup and a shoulder.
struct RidgeOptions {
  /// Normals looked at, about the table's: wide enough for both sides of a roof of 60 deg, narrow
  /// enough to leave out walls.
  double window_rad = 1.15;
  /// A normal is square to the axis if its share along it is at most this (20 deg); the others are
  /// of end faces and edges.
  double max_along_axis = 0.35;
  double min_square_share = 0.8;  ///< of the upward points; less is no body about one axis
  /// Mean square of the normals' share along the axis: square within about 12 deg in the mean.
  double max_mean_square = 0.045;
  double max_axis_slope = 0.5;  ///< of the axis, sine (30 deg): a steeper body stands
  /// Spread of the middle 60 % of the normals: a plane's is about 10 deg with its rounded edges, a
  /// lying cylinder's 45 deg and more.
  double min_spread_rad = 0.44;
  /// Of sine and offset across the axis. The near lip and the far wall of a cup both face the
  /// sensor; on a ridge the side tells which way the surface faces.
  double min_correlation = 0.7;
  /// Of the ridge's length to the body's: a cap above a shoulder is not the shoulder's ridge.
  double min_length_share = 0.6;
  /// Points that face further from the ridge's normal than this (26 deg) say how far the surface
  /// comes down; nearer ones hardly do.
  double off_ridge_rad = 0.45;
  /// How far the surface comes down, of what a circle with these normals would: about 1 for a
  /// circle, 0.5 and more for a flat ellipse, next to nothing for the lip of a cup, which has
  /// normals to all sides at one height.
  double min_drop_share = 0.35;
  double half_angle_rad = 0.35;  ///< of the strip's normals about the ridge's (20 deg)
};

/// Circles through rim points (eq. 5.6, 5.7).
struct CircleFitOptions {
  int draws = 100;  ///< as of the planes (eq. 5.5)
  AdaptiveLength distance_m{0.002, {.noises = 2.5, .spacings = 0.67}};  ///< eq. 5.6
  double max_radius_m = 0.15;  ///< a wider circle is no tabletop object's
  int refits = 3;              ///< to the inliers, by least squares; ends where nothing is gained
  /// A refit that holds less than this share of the points before it lies worse. Not 1: a draw can
  /// hold a point or two more than the least-squares circle.
  double refit_share = 0.98;
};

/// Whether a body is rotational, and about which axis (section 5.1.3, eq. 5.8).
struct AxisOptions {
  double rim_share = 0.8;   ///< of the rim points on one circle (section 5.1.3)
  double body_share = 0.8;  ///< of the points that agree with their section (section 5.1.3)
  /// Of the points that agree and whose normals pass the axis, too (see max_tangential). A round
  /// wall has 0.67 and more, since normals at its outline are turned towards the sensor; the sides
  /// of a square column have a third.
  double normal_share = 0.66;
  /// Thickness of the section planes: two rows of points.
  AdaptiveLength section_m{0.004, {.noises = 2.5, .spacings = 1.35}};
  /// A short arc fits nearly any curve: the rim has to go this far round (twelve bins of ArcOf).
  double min_arc_rad = base::Deg(115.0);
  /// The same (240 deg) for a rim with bridged gaps, whose straight sides count for few points.
  double min_bridged_arc_rad = 4.2;
  /// The same for the body of one that lies (90 deg): half of it at most is seen, and the outline's
  /// normals do not count.
  double min_lying_arc_rad = 1.5;
  /// In the place of body_share for such a body: what its ends and a handle add is not square to
  /// it.
  double lying_body_share = 0.88;
  /// A body is not under the table; by so much its circle may be too large.
  AdaptiveLength max_sunk_m{0.006, {.noises = 3.0, .gaps = 1.3}};
  /// The same for the body about an axis from its rim: the narrow side of a bottle is round, too,
  /// but not so far. A round one's seen side has 110 deg and more.
  double min_body_arc_rad = base::Deg(90.0);
  int min_body_points = 20;  ///< fewer say nothing about the body
  /// Normals nearer to the axis than this cosine (45 deg) are of caps, floors and lips.
  double max_along_axis = 0.7;
  /// A rotational surface's normals pass the axis: their share along the circle, sin(20 deg),
  /// leaves room for noise and turns the ends of ellipses away.
  double max_tangential = 0.34;
  /// Within what a small rim leaves uncertain, an object that stands is upright.
  double upright_rad = base::Deg(5.0);

  // Refinement by the body.
  int refine_rounds = 5;       ///< of Gauss-Newton; each costs one pass over the body
  double max_shift_m = 0.004;  ///< further off than a rim's grazing side can put its circle
  /// Least eigenvalue of the normal matrix a point: that of an arc of about 60 deg.
  double min_conditioning = 0.02;
  double top_sections_m = 0.012;  ///< the wall under a rounded rim that gives the radius

  // The axis from the body where the top is a thin ring, or a lid whose own rim gives no circle.
  /// How far round such a ring's wall has to be seen, in the mean over its sections: eleven bins.
  double min_ring_arc_rad = base::Deg(105.0);
  /// How far round the circle the rim of such a lid goes: half a disc's goes 180 deg and a bin or
  /// two at its corners.
  double min_lid_arc_rad = base::Deg(205.0);
  /// Of the lid's rim from the body's circle: it is rounded.
  AdaptiveLength lid_distance_m{0.006, {.noises = 3.0, .gaps = 1.3}};
  double ring_share = 0.35;   ///< a top is a thin ring if it fills less than this of its circle
  double max_wall_m = 0.010;  ///< of a cup, with its lip
  /// In the place of body_share there: a handle in front of the body and normals at its edges count
  /// against it, while the ring already is the better witness.
  double ring_body_share = 0.6;
  int min_wall_points = 60;  ///< three sections' worth; half of them have to agree
  /// Sine of the angle between two normals (12 deg): more nearly parallel ones meet anywhere.
  double min_normals_sine = 0.2;
};

/// Clipped rotational parts (section 5.1.3) and fragments.
struct MergeOptions {
  // Cheap conditions before two parts are fitted as one rotational object: what rim noise and an
  // axis from half a rim leave uncertain.
  double max_height_difference_m = 0.010;
  double max_center_distance_m = 0.010;
  /// The body share holds for the union (as printed); the part with the handle may be below it. Of
  /// the points that could agree; of all points where the union has no rim.
  double min_own_body = 0.5;

  // Fragments (see fragments.h).
  AdaptiveLength fragment_gap_m{
      0.012, {.noises = 6.0, .gaps = 2.6}};  ///< the widest gap that is taken for lost points
  AdaptiveLength footprint_margin_m{
      0.005, {.spacings = 1.7}};  ///< round a footprint: two and a half point spacings
  AdaptiveLength height_margin_m{0.003,
                                 {.noises = 3.0}};  ///< of "not above the top": noise and smoothing
  double within_share = 0.7;  ///< of a fragment's points over the footprint that it is in
  double cap_share = 0.9;     ///< of a cap's points over the cross-section of its host
  /// Points this near were neighbors to the segmentation, which cut between them: their parts are
  /// not joined as kSurface, but as kHanging. 0: the segmentation cuts nothing (perceive.cpp sets
  /// it).
  double cut_m = 0.0;
  /// What hangs in the air at a host is of it: the sensor saw through under this share of its
  /// points; a handle 20 mm over the table has 0.36, what leans on a host with its foot hidden next
  /// to none. Larger: handles are things of their own; smaller: leaning things are handles.
  double min_free_below = 0.25;
  /// Of its points to its host's: a handle has up to 0.195. Larger: what leans on a host is its
  /// handle (11 things to 3 handles with 0.5, in 360 scans of clutter); smaller: handles are things
  /// of their own.
  double max_hanging_share = 0.2;
  // Of a cap, as shares of its host's length and width. The shipped bottles' caps are up to 0.27 as
  // long and 0.62 as wide. Larger: small things that lie in the middle of others are caps.
  double max_cap_length = 0.4;
  double max_cap_width = 0.7;
  double max_cap_offset = 0.15;  ///< of its middle from its host's: what occlusion makes of it
  /// Of the points of a piece under the host's top, to the host's. Larger: what lies under a thing
  /// is of it (13 above this to 4, in 480 scans; 3 to 4 below); smaller: crumbs are objects.
  double max_crumb_share = 0.05;
  int min_pairs = 8;  ///< of points across the gap; fewer happen between any two neighbors
  double min_continuing = 0.5;  ///< share of the pairs whose surfaces continue each other
  AdaptiveLength max_in_front_m{
      0.0015,
      {.noises = 3.0,
       .spacings = 0.5}};     ///< of the other side's tangent plane: three times the noise
  double max_sideways = 0.5;  ///< share of a gap across the sensor's viewing plane (30 deg)
};

/// Open boxes that objects lie in (internal/container.h).
struct ContainerOptions {
  /// A wall's points lie this near the border of the box: its thickness, and how far noise and
  /// spacing move its ends. Larger: things that lean on a wall are taken for it.
  AdaptiveLength wall_m{0.008, {.noises = 3.0, .gaps = 2.0}};
  /// A segment is a piece of wall if this share of it lies within so many wall_m of the border:
  /// what leans flat on a wall and is no thicker goes with it.
  double piece_share = 0.9;
  double piece_walls = 1.5;
  /// Of a box, both ways: wider than a hand opens. A narrower ring is a vessel to be grasped.
  double min_side_m = 0.15;
  /// How much of the border is seen to be as high as its rim: things in the box hide up to a fifth
  /// of one (24 simulated boxes of twelve things). Less: things that stand about make a rectangle
  /// by chance, or a round pot does, which has three fifths.
  double min_coverage = 0.75;
  double max_upward = 0.5;  ///< of an upright surface's normals: their share along the table's
  /// Over the rim, for noise: what rises above it at the border is not of the box; what differs
  /// from its height by twice as much is not level.
  AdaptiveLength rim_margin_m{0.003, {.noises = 3.0}};
  double coverage_step_m = 0.010;  ///< in which it is counted: two lines of a line scanner
  int min_end_points = 4;  ///< that lie within wall_m of a sheet's end; fewer are mixed points
  /// More of the box's area at the height of its rim is a lid.
  double max_lid = 0.5;
  double direction_step_rad = base::Deg(2.0);  ///< of the histogram of the walls' directions
  int max_directions = 3;                      ///< of its maxima that are tried
  int turn_rounds = 2;                         ///< in which a direction is made better
};

/// The unseen sides (section 5.1.4).
struct CompletionOptions {
  double step_rad = 0.0872665;  ///< 5 deg (section 5.1.4)
  double mirror_share = 0.85;   ///< of the mirrored points that must be in unseen space
  /// An image point is free only if what was measured lies this far behind it: cells of directions
  /// are 4 mm wide and surfaces slope.
  AdaptiveLength free_margin_m{0.006, {.noises = 4.0, .spacings = 2.0}};
  double min_inclination_rad = 0.21;  ///< a top turned further (12 deg) has an upper edge
  double max_top_share = 0.6;  ///< of the body's rectangle; a smaller top is turned by half about

  /// A top surface this many times as long as wide says which way the object lies.
  double min_elongation = 1.2;
  /// The end of a rectangle's side: the outermost point that has this share of all points, and at
  /// least so many, within the band below it. What lies further out is mixed points.
  AdaptiveLength end_band_m{0.002, {.spacings = 0.67}};
  double end_share = 0.002;
  int min_end_points = 4;

  double wall_step_m = 0.005;  ///< between the posts of a wall, and between the points on one
  AdaptiveLength wall_outline_m{
      0.003,
      {.noises = 2.0,
       .spacings = 1.0}};  ///< points this near an outline's side say how high its wall is
  AdaptiveLength cell_m{
      0.006, {.gaps = 1.3}};  ///< of the grid that the fill is counted on: three point spacings
  /// An outline that is filled less than this is not convex and gets several hulls.
  double min_fill = 0.75;
  double slice_m = 0.020;       ///< thickness of those hulls
  double slice_overlap = 0.15;  ///< of a slice; so that no gap is left between neighbors

  // With complete_leaning.
  double min_lean_rad = 0.14;       ///< of the top (8 deg): noise and the table's own fit are below
  double max_lean_rad = 1.13;       ///< a top that leans further (65 deg) is a side
  double min_lean_depth_m = 0.012;  ///< what is seen below the top says how thick the object is
  /// Points further than this outside the top's outline, along its normal, are no face square to it
  /// ...
  AdaptiveLength lean_margin_m{0.006, {.noises = 4.0, .gaps = 1.0}};
  double max_lean_outside = 0.15;  ///< ... and at most this share of all may be there

  // Bodies of revolution.
  int sides = 36;         ///< of the surface: 0.4 % of the radius inside the circle
  double wall_m = 0.004;  ///< a wall, or the floor under a cavity, that was seen from one side only
  int min_section_points = 3;        ///< sections with fewer are taken from their neighbors
  double min_floor_depth_m = 0.010;  ///< below the rim; higher points are of the lip
  double min_floor_cosine = 0.8;     ///< of a floor's normals with the axis (37 deg)
  int min_floor_points = 10;         ///< fewer are mixed points in the cavity
  double min_axis_cosine = 0.3;      ///< bounds the length of a leaning body (73 deg)
  AdaptiveLength attached_m{
      0.003,
      {.noises = 4.0,
       .spacings = 1.0}};  ///< a handle starts this far outside the circles: past their noise
  AdaptiveLength link_m{
      0.006,
      {.noises = 3.0,
       .gaps = 1.3}};            ///< three point spacings: points this near are of one attachment
  int min_attached_points = 15;  ///< fewer are stray points

  // What a part stands on.
  /// Points this low stand on the table: those of the table's clearance are not in the cloud.
  AdaptiveLength on_table_m{0.012, {.noises = 10.0, .spacings = 4.0}};
  int min_support_points = 15;  ///< of other parts under a footprint; fewer are stray points
};

/// Options of sections 5.1.3 and 5.1.4 and of the open/closed test of section 5.2. The switches of
/// its base are what goes beyond them.
struct FeatureOptions : FeatureAdditions {
  TopSurfaceOptions top;
  RidgeOptions ridge;
  CircleFitOptions circle;
  AxisOptions axis;
  MergeOptions merge;
  ContainerOptions container;
  CompletionOptions completion;

  /// With higher_tops: the highest plane that holds this share of the fullest one's points is the
  /// top.
  double top_plane_share = 0.3;
  /// With drop_needles: a part whose footprint is nowhere this long is none.
  double min_footprint_m = 0.015;

  // Open or closed.
  double open_sphere_factor = 2.0 / 3.0;  ///< eq. 5.9
  /// With open_strays: points inside the sphere that are still taken for none, as a share of the
  /// top surface's.
  double open_stray_share = 0.02;
};

}  // namespace rangegrasp::perception
