#pragma once

#include "base/yaml_map.h"
#include "perception/segment.h"

namespace rangegrasp::perception {

/// What perception does beyond the dissertation: these, SegmentAdditions and FeatureAdditions; all
/// off: the method as published (base/words.h). docs/results.md has the reasons.
struct PreprocessAdditions {
  bool adapt_lengths = true;
  bool robust_table = true;
  bool repeated_filter = true;
  bool neighborhood_normals = true;
  bool widened_normals = true;  ///< on faces seen at a grazing angle, up to max_widening
};
constexpr std::array<base::Addition<PreprocessAdditions>, 5> AdditionsOf(
    const PreprocessAdditions*) {
  using A = PreprocessAdditions;
  return {{
      {"adapt_lengths", &A::adapt_lengths,
       "adapt lengths to the measured noise and point spacing; off: the published lengths"},
      {"robust_table", &A::robust_table,
       "if stray points hide the table, search again without the hull's vertices, and for the "
       "plane with most points"},
      {"repeated_filter", &A::repeated_filter,
       "repeat the outlier filter until it finds none: far outliers hide nearer ones"},
      {"neighborhood_normals", &A::neighborhood_normals,
       "estimate normals from the points within normal_radius_mm; off: from the faces of the "
       "segments' mesh"},
      {"widened_normals", &A::widened_normals,
       "with neighborhood_normals: enlarge the neighborhood if its points all lie on one line"},
  }};
}
static_assert(base::AllAdditionsListed<PreprocessAdditions>());

// Defaults that stand in the dissertation name their equation or section. The others are this
// program's own; their comments say what they trade off. An AdaptiveLength stands for noise or
// spacing and says how much of it; all other lengths are an object's or a hand's and stay.

/// How the table is looked for on the hull (FindTable).
struct TableSearchOptions {
  double max_tilt_rad = base::Deg(15.0);  ///< of the normal from up_C: a hand-held estimate's error
  /// Two faces of the hull are one plane within this angle and share of the preselection. Larger: a
  /// slope over stray points hides the table's own face; smaller: more candidates to rank.
  double same_plane_rad = base::Deg(1.0);
  double same_plane_share = 0.2;
  /// Of the hull, evenly taken. More: slower, more strays bend it; fewer: it lies a little higher.
  std::size_t hull_points = 2000;
  std::size_t ranking_points = 4000;  ///< rank candidates and hypotheses; all points the finalists
  std::size_t finalists = 5;
  double min_support = 0.05;      ///< share of the points that a table holds
  double max_below = 0.01;        ///< share that may lie under it
  int peelings = 4;               ///< how often the hull's vertices are removed as outliers
  int dominant_planes = 3;        ///< tried where the hull shows no table
  double dominant_support = 0.2;  ///< share of the points that such a plane holds
};

/// Options of section 5.1.1 (and 4.2.1-4.2.2); defaults are the dissertation's for its scanner.
struct PreprocessOptions : PreprocessAdditions {
  /// Distance to the deepest hull plane of what is fitted (5.1.1): strays bend the hull.
  AdaptiveLength preselection_m{0.005, {.noises = 5.0}};
  int plane_draws = 100;                                    ///< section 5.1.1
  AdaptiveLength plane_distance_m{0.002, {.noises = 2.5}};  ///< 5.1.1: nearly all of a normal one
  /// A table of 200,000 points leaves a few dozen above five deviations where noise grows with
  /// distance; less cuts objects.
  AdaptiveLength table_clearance_m{0.004, {.noises = 5.0}};
  bool filter = true;  ///< the compression-rate filter, eq. 4.5-4.9
  /// Eq. 4.8 and 4.9 remove a point only where it is isolated, too. No addition, but how the text
  /// is read: as printed they would remove a large part of a scan (CompressionRateFilter), and the
  /// dissertation removed 38 of 22,377 points.
  bool isolated_outliers = true;
  /// The unit of length of eq. 4.8: the dissertation's millimetre, half of its scanner's spacing.
  AdaptiveLength filter_unit_m{0.001, {.spacings = 0.34}};
  /// A point with a neighbor this near is no outlier. 0: as published, but the filter then removes
  /// half of an evenly sampled surface, where d_a, d_k and all distances are alike. Larger: strays.
  AdaptiveLength filter_keep_m{0.0, {.spacings = 1.3}};
  bool smooth = true;  ///< the average filter (section 5.1.1)
  /// The eight neighbors of an even scan. Larger rounds edges: it grows with noise alone.
  AdaptiveLength smooth_radius_m{0.003, {.noises = 3.0}};
  /// Of the normals (sections 4.2.2, 5.1.1): ten points of an even scan.
  AdaptiveLength normal_radius_m{0.005, {.noises = 5.0, .spacings = 1.7}};
  double max_widening = 4.0;  ///< of the radius, with widened_normals. Larger rounds edges
  std::optional<Eigen::Vector3d> up_C;  ///< away from the table, where it is known
  TableSearchOptions table;
};

/// Top surfaces (section 5.1.3, eq. 5.5) and their rims.
struct TopSurfaceOptions {
  int plane_draws = 100;                                    ///< eq. 5.5
  AdaptiveLength plane_distance_m{0.002, {.noises = 2.5}};  ///< as of the table (section 5.1.1)
  /// Between a top's normals and the table's, 45 deg: their main component is along it (5.1.3).
  double normal_angle_rad = 0.785;
  int min_plane_points = 12;       ///< three rows of four. Larger: small lids are lost
  double min_upward_share = 0.04;  ///< of a part's points; fewer are the rounding of an edge
  int planes = 3;  ///< looked at for one above the fullest: a lip, a shoulder, a floor
  double plane_separation = 2.0;  ///< of different planes, in plane distances
  /// Depth of the highest points that stand in for a plane: what a plane's inliers span.
  AdaptiveLength slab_m{0.004, {.noises = 5.0, .spacings = 1.35}};
  double fold_elongation = 4.0;  ///< a longer slab is a fold; less is the lip of something
  /// Of the rim's 2-D shape. Smaller: holes between points; larger: the mouth of a cup closes.
  AdaptiveLength rim_alpha_m{0.006, {.noises = 3.0, .gaps = 1.3}};
  AdaptiveLength bridged_rim_alpha_m{0.030, {.gaps = 6.5}};  ///< bridges gaps up to twice as wide
};

/// How a ridge is distinguished from a plane, the lip of a cup and a shoulder.
struct RidgeOptions {
  double window_rad = 1.15;        ///< about up: both sides of a roof of 60 deg, without walls
  double max_along_axis = 0.35;    ///< of normals square to the axis (20 deg); others are of ends
  double min_square_share = 0.8;   ///< of the upward points; less is no body about one axis
  double max_mean_square = 0.045;  ///< of the normals' share along the axis: 12 deg in the mean
  double max_axis_slope = 0.5;     ///< of the axis, sine (30 deg): a steeper body stands
  /// Of the middle 60 % of the normals: a plane's spread is about 10 deg, a cylinder's from 45 deg.
  double min_spread_rad = 0.44;
  /// Of sine and offset across the axis: the near lip and the far wall of a cup face the same way.
  double min_correlation = 0.7;
  /// Of the ridge's length to the body's: a cap above a shoulder is not the shoulder's ridge.
  double min_length_share = 0.6;
  double off_ridge_rad = 0.45;  ///< points that face further off (26 deg) give the descent
  /// Of the descent of a circle with these normals: about 1 for a circle, 0.5 and more for a flat
  /// ellipse, next to nothing for the lip of a cup, with normals to all sides at one height.
  double min_drop_share = 0.35;
  double half_angle_rad = 0.35;  ///< of the strip's normals about the ridge's (20 deg)
};

/// Circles through rim points (eq. 5.6, 5.7).
struct CircleFitOptions {
  int draws = 100;  ///< as of the planes (eq. 5.5)
  AdaptiveLength distance_m{0.002, {.noises = 2.5, .spacings = 0.67}};  ///< eq. 5.6
  double max_radius_m = 0.15;  ///< a wider circle is no tabletop object's
  int refits = 3;              ///< to the inliers, by least squares; ends where nothing is gained
  /// Of the points before a refit. Not 1: a draw can hold a few more than the least-squares circle.
  double refit_share = 0.98;
};

/// Whether a body is rotational, and about which axis (section 5.1.3, eq. 5.8).
struct AxisOptions {
  double rim_share = 0.8;   ///< of the rim points on one circle (section 5.1.3)
  double body_share = 0.8;  ///< of the points that agree with their section (section 5.1.3)
  /// Of the points that agree and whose normals pass the axis: a round wall has 0.67 and more
  /// (normals at its outline turn towards the sensor), 29 generated bottles, cups and cylinders
  /// alone on the table 0.94 and more; a square column a third, hexagons 0.59 to 0.74.
  double normal_share = 0.66;
  AdaptiveLength section_m{0.004, {.noises = 2.5, .spacings = 1.35}};  ///< thick: two rows
  /// A short arc fits nearly any curve: the rim has to go this far round (twelve bins of ArcOf).
  double min_arc_rad = base::Deg(115.0);
  /// For a rim with bridged gaps, whose straight sides count for few points (240 deg).
  double min_bridged_arc_rad = 4.2;
  double min_lying_arc_rad = 1.5;  ///< for a lying body (90 deg): half of it is seen at most
  double lying_body_share = 0.88;  ///< replaces body_share for it: ends and handles are not square
  /// A body is not under the table; by so much its circle may be too large.
  AdaptiveLength max_sunk_m{0.006, {.noises = 3.0, .gaps = 1.3}};
  /// About its rim's axis: a round body shows 110 deg and more, a bottle's narrow side less.
  double min_body_arc_rad = base::Deg(90.0);
  int min_body_points = 20;             ///< fewer say nothing about the body
  double max_along_axis = 0.7;          ///< normals nearer to it (45 deg) are of caps, floors, lips
  double max_tangential = 0.34;         ///< of normals, sin(20 deg): noise, but no ends of ellipses
  double upright_rad = base::Deg(5.0);  ///< what a small rim leaves uncertain

  // Refinement by the body.
  int refine_rounds = 5;           ///< of Gauss-Newton; each costs one pass over the body
  double max_shift_m = 0.004;      ///< further off than a rim's grazing side can put its circle
  double min_conditioning = 0.02;  ///< least eigenvalue of the normal matrix a point: of 60 deg
  double top_sections_m = 0.012;   ///< the wall under a rounded rim that gives the radius

  // The axis from the body where the top is a thin ring, or a lid whose own rim gives no circle.
  double min_ring_arc_rad = base::Deg(105.0);  ///< of the ring's wall, mean over its sections
  /// Of the lid's rim: half a disc's goes 180 deg and a bin or two at its corners.
  double min_lid_arc_rad = base::Deg(205.0);
  /// Of the lid's rim from the body's circle: it is rounded.
  AdaptiveLength lid_distance_m{0.006, {.noises = 3.0, .gaps = 1.3}};
  double ring_share = 0.35;       ///< a top is a thin ring if it fills less than this of its circle
  double max_wall_m = 0.010;      ///< of a cup, with its lip
  double ring_body_share = 0.6;   ///< replaces body_share there: a handle may stand in front
  int min_wall_points = 60;       ///< three sections' worth; half of them have to agree
  double min_normals_sine = 0.2;  ///< between two (12 deg): more nearly parallel ones meet anywhere
};

/// Clipped rotational parts (section 5.1.3) and fragments.
struct MergeOptions {
  // Cheap conditions before two parts are fitted as one rotational object: what rim noise and an
  // axis from half a rim leave uncertain.
  double max_height_difference_m = 0.010;
  double max_center_distance_m = 0.010;
  /// Of each part's points that could agree (all, where the union has no rim); the body share holds
  /// for the union, as printed: the part with the handle may be below it.
  double min_own_body = 0.5;

  // Fragments (FindKinship).
  AdaptiveLength fragment_gap_m{0.012, {.noises = 6.0, .gaps = 2.6}};  ///< widest of lost points
  /// Between a round host and its cap or handle: a shoulder that turns away from the sensor.
  double hidden_gap_m = 0.030;
  AdaptiveLength footprint_margin_m{0.005, {.spacings = 1.7}};  ///< two and a half point spacings
  AdaptiveLength height_margin_m{0.003, {.noises = 3.0}};       ///< of "not above the top"
  double within_share = 0.7;  ///< of a fragment's points over the footprint that it is in
  double cap_share = 0.8;     ///< of a cap's points over the cross-section of its host
  /// Between points this near the segmentation has cut: their parts are not joined as kSurface, but
  /// as kHanging. 0: it cuts nothing (perceive.cpp sets it).
  double cut_m = 0.0;
  /// Of what hangs at a host, points that the sensor saw through under: a handle 20 mm over the
  /// table has 0.36, what leans on a host next to none. Larger: handles become objects; smaller:
  /// leaning things become handles.
  double min_free_below = 0.25;
  double min_free_below_apart = 0.5;  ///< if it is not close to its host: handles had 0.69 and more
  /// Of its points to its host's: a handle has up to 0.195. Larger: what leans is a handle (11
  /// things to 3 handles with 0.5, in 360 scans of clutter); smaller: handles become objects.
  double max_hanging_share = 0.2;
  // Of a cap, as shares of its host's length and width: the necks of twenty generated bottles are
  // up to 0.41 as long and 0.65 as wide. Larger: small things that lie in the middle of others are
  // caps.
  double max_cap_length = 0.45;
  double max_cap_width = 0.7;
  double max_cap_offset = 0.15;  ///< of its middle from its host's: what occlusion makes of it
  /// Of a piece's points under the host's top. Larger: what lies under a thing is of it (13 above
  /// this to 4, in 480 scans; 3 to 4 below); smaller: crumbs are objects.
  double max_crumb_share = 0.05;
  int min_pairs = 8;  ///< of points across the gap; fewer happen between any two neighbors
  double min_continuing = 0.5;  ///< share of the pairs whose surfaces continue each other
  /// Of the other side's tangent plane: three times the noise.
  AdaptiveLength max_in_front_m{0.0015, {.noises = 3.0, .spacings = 0.5}};
  double max_sideways = 0.5;  ///< share of a gap across the sensor's viewing plane (30 deg)

  // Parts that touch nothing but each other (MergeLone). Larger: small things that stand together
  // or on each other are one; smaller: toys, pliers and vases fall into parts. Of 56 scans of
  // household things alone that were cut, 49 are whole again; of 203 heaps of several things in
  // clutter, 14 are one.
  double max_lone_width_m = 0.10;  ///< what a hand can hold
  double max_lone_length_m = 0.25;
  double max_lone_height_m = 0.12;               ///< of its top; what is stacked is higher
  double max_lone_crease_rad = base::Deg(55.0);  ///< mean angle of a concave edge between two parts
};

/// Open boxes that objects lie in (internal/container.h).
struct ContainerOptions {
  /// From the border of the box: a wall's thickness and noise. Larger: what leans on it is wall.
  AdaptiveLength wall_m{0.008, {.noises = 3.0, .gaps = 2.0}};
  double piece_share = 0.9;  ///< of a piece of wall within so many wall_m of the border
  double piece_walls = 1.5;
  double min_side_m = 0.15;  ///< wider than a hand opens; a narrower ring is a vessel to be grasped
  /// Of the border that is seen as high as its rim; things in the box hide the rest. Of 40 scans of
  /// 20 generated boxes, 200 to 420 mm long and turned, with ten generated objects in them, 37 have
  /// more, 30 more than 0.75; of 40 heaps without a box none more than 0.58. A round pot has 0.6.
  double min_coverage = 0.65;
  double max_upward = 0.5;  ///< of an upright surface's normals: their share along the table's
  /// Over the rim, for noise; what differs from its height by twice as much is not level.
  AdaptiveLength rim_margin_m{0.003, {.noises = 3.0}};
  double coverage_step_m = 0.010;  ///< in which it is counted: two lines of a line scanner
  int min_end_points = 4;  ///< that lie within wall_m of a sheet's end; fewer are mixed points
  double max_lid = 0.5;    ///< more of the box's area at the height of its rim is a lid
  double direction_step_rad = base::Deg(2.0);  ///< of the histogram of the walls' directions
  int max_directions = 3;                      ///< of its maxima that are tried
  int turn_rounds = 2;                         ///< in which a direction is made better
};

/// The unseen sides (section 5.1.4).
struct CompletionOptions {
  double step_rad = 0.0872665;  ///< 5 deg (section 5.1.4)
  double mirror_share = 0.85;   ///< of the mirrored points that must be in unseen space
  /// From a free point to what was measured behind it: directions' cells are 4 mm wide.
  AdaptiveLength free_margin_m{0.006, {.noises = 4.0, .spacings = 2.0}};
  double min_inclination_rad = 0.21;  ///< a top turned further (12 deg) has an upper edge
  double max_top_share = 0.6;   ///< of the body's rectangle; a smaller top is turned by half about
  double min_elongation = 1.2;  ///< of a top surface that says which way the object lies
  /// A rectangle's side ends at the outermost point with this share of all points, and at least so
  /// many, within the band below it; further out are mixed points.
  AdaptiveLength end_band_m{0.002, {.spacings = 0.67}};
  double end_share = 0.002;
  int min_end_points = 4;

  double wall_step_m = 0.005;  ///< between the posts of a wall, and between the points on one
  /// Points this near an outline's side say how high its wall is.
  AdaptiveLength wall_outline_m{0.003, {.noises = 2.0, .spacings = 1.0}};
  AdaptiveLength cell_m{0.006, {.gaps = 1.3}};  ///< of the fill's grid: three point spacings
  double min_fill = 0.75;       ///< an outline that is filled less is not convex: several hulls
  double slice_m = 0.020;       ///< thickness of those hulls
  double slice_overlap = 0.15;  ///< of a slice; so that no gap is left between neighbors

  // With complete_leaning.
  double min_lean_rad = 0.14;       ///< of the top (8 deg): noise and the table's own fit are below
  double max_lean_rad = 1.13;       ///< a top that leans further (65 deg) is a side
  double min_lean_depth_m = 0.012;  ///< what is seen below the top says how thick the object is
  /// Points further outside the top's outline, along its normal, are of no face square to it.
  AdaptiveLength lean_margin_m{0.006, {.noises = 4.0, .gaps = 1.0}};
  double max_lean_outside = 0.15;  ///< of all points

  // Bodies of revolution.
  int sides = 36;         ///< of the surface: 0.4 % of the radius inside the circle
  double wall_m = 0.004;  ///< a wall, or the floor under a cavity, that was seen from one side only
  int min_section_points = 3;        ///< sections with fewer are taken from their neighbors
  double min_floor_depth_m = 0.010;  ///< below the rim; higher points are of the lip
  double min_floor_cosine = 0.8;     ///< of a floor's normals with the axis (37 deg)
  int min_floor_points = 10;         ///< fewer are mixed points in the cavity
  double min_axis_cosine = 0.3;      ///< bounds the length of a leaning body (73 deg)
  /// A handle starts this far outside the circles: past their noise.
  AdaptiveLength attached_m{0.003, {.noises = 4.0, .spacings = 1.0}};
  AdaptiveLength link_m{0.006, {.noises = 3.0, .gaps = 1.3}};  ///< within one attachment
  int min_attached_points = 15;                                ///< fewer are stray points

  // What a part stands on: the table, if it comes this low (its clearance is not in the cloud).
  AdaptiveLength on_table_m{0.012, {.noises = 10.0, .spacings = 4.0}};
  int min_support_points = 15;  ///< of other parts under a footprint; fewer are stray points
};

struct FeatureAdditions {   // with the reason where the rows below do not say it
  bool ridge_tops = true;   ///< all planes that touch a lying cylinder hold about as many points
  bool higher_tops = true;  ///< the floor of a container, or a shoulder, can hold more than the rim
  bool slab_tops = true;
  bool rectangle_axes = true;  ///< of a surface seen in part the covariance turns
  bool arc_rule = true;        ///< short arcs fit any curve
  bool bridged_rims = true;    ///< lost points leave gaps
  bool upright_axes = true;
  bool radial_normals = true;
  bool refine_axis = true;      ///< the rim's far side is seen at a grazing angle
  bool axis_from_body = true;   ///< a cup's lip is as wide as profiles are apart; gloss tears rims
  bool lying_axes = true;       ///< their top has no circle
  bool lip_tops = true;         ///< the floor of a bowl holds more points than its lip
  bool merge_fragments = true;  ///< off: only clipped rotational parts are merged
  bool lone_objects = true;     ///< concave things are cut at their necks, and a scan shows no more
  /// Without it a hand that closes on the seen half of a lying cylinder meets the other half.
  bool complete_by_symmetry = true;
  bool complete_leaning = true;  ///< what leans has no faces square to the table
  bool trim_strays = true;       ///< mixed points
  bool drop_needles = true;      ///< of mixed points along one ray
  bool open_strays = true;  ///< mixed points hang between a container's near rim and its far wall
};
constexpr std::array<base::Addition<FeatureAdditions>, 19> AdditionsOf(const FeatureAdditions*) {
  using A = FeatureAdditions;
  return {{
      {"ridge_tops", &A::ridge_tops, "accept the ridge of a lying cylinder or of a roof as top"},
      {"higher_tops", &A::higher_tops,
       "use a plane above the largest one as top if it has top_plane_share of its points"},
      {"slab_tops", &A::slab_tops, "use the highest points as top if no plane has enough points"},
      {"rectangle_axes", &A::rectangle_axes,
       "principal axis of a top from its minimum-area rectangle; off: from its covariance"},
      {"arc_rule", &A::arc_rule,
       "accept a circle only if the rim covers a third of it and the body a quarter"},
      {"bridged_rims", &A::bridged_rims, "test rims again with their gaps bridged"},
      {"upright_axes", &A::upright_axes, "test a nearly upright axis as upright"},
      {"radial_normals", &A::radial_normals,
       "points agree with a rotation axis only if their normals meet it"},
      {"refine_axis", &A::refine_axis, "correct the rim's circle with the points of the body"},
      {"axis_from_body", &A::axis_from_body,
       "find an axis from the walls if the rim gives no circle: thin lips, lids with holes"},
      {"lying_axes", &A::lying_axes, "find rotational bodies that lie on their side"},
      {"lip_tops", &A::lip_tops, "find the axis of bowls from their lips"},
      {"merge_fragments", &A::merge_fragments, "join segments of one object"},
      {"lone_objects", &A::lone_objects,
       "join touching segments that together stand alone and are no wider than a hand opens"},
      {"complete_by_symmetry", &A::complete_by_symmetry,
       "mirror the surface of objects that are not rotational"},
      {"complete_leaning", &A::complete_leaning,
       "complete tilted objects perpendicular to their top; off: perpendicular to the table"},
      {"trim_strays", &A::trim_strays,
       "exclude single points beyond an object's ends from its completed shape"},
      {"drop_needles", &A::drop_needles,
       "remove objects narrower than min_footprint_mm in both directions"},
      {"open_strays", &A::open_strays,
       "allow open_stray_share of the points in the sphere of an open object; off: none"},
  }};
}
static_assert(base::AllAdditionsListed<FeatureAdditions>());

/// Options of sections 5.1.3 and 5.1.4 and of the open/closed test of section 5.2. The switches of
/// its base are what goes beyond them.
struct FeatureOptions : FeatureAdditions {
  TopSurfaceOptions top;
  RidgeOptions ridge;
  CircleFitOptions circle;
  AxisOptions axis;
  MergeOptions merge;
  /// Both methods: the hand may collide with a box (figure 5.17), but is not to grasp it.
  bool containers = true;
  ContainerOptions container;
  CompletionOptions completion;

  double top_plane_share = 0.3;
  double min_footprint_m = 0.015;
  double open_sphere_factor = 2.0 / 3.0;  ///< eq. 5.9
  double open_stray_share = 0.02;         ///< of the top surface's points
};

struct PerceptionOptions {
  PreprocessOptions preprocess;
  SegmentOptions segment;
  FeatureOptions features;
  SamplingOptions sampling;
  std::optional<double> noise_m;  ///< the sensor's where it is known [m]; else it is measured
  /// The noise is the median of what the observation states of its samples. For a sensor whose
  /// errors are the same over whole neighborhoods, where they do not show.
  bool stated_noise = false;
};

/// Sets every AdaptiveLength that was not given to what the sampling asks for.
void AdaptLengths(const Sampling& sampling, PerceptionOptions& options);

/// Reads the keys of the mapping `perception`, to its end.
/// @throws base::InputError
void ReadOptions(base::YamlMap map, PerceptionOptions& options);

}  // namespace rangegrasp::perception
