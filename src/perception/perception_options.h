#pragma once

#include "base/yaml_map.h"
#include "perception/segment.h"

namespace rangegrasp::perception {

/// Extensions of perception beyond the dissertation: these, SegmentAdditions and FeatureAdditions.
/// With all off, it is the published method (base/words.h). docs/results.md has the reasons.
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

// Defaults from the dissertation name their equation or section. The others are this program's own;
// their comments state the trade-off. An AdaptiveLength covers noise or spacing and says how much
// of it; all other lengths belong to an object or a hand and do not adapt.

/// How the table is searched for on the hull (FindTable).
struct TableSearchOptions {
  double max_tilt_rad = base::Deg(15.0);  ///< of the normal from up_C: a hand-held estimate's error
  /// Two faces of the hull are one plane within this angle and share of the preselection. Larger: a
  /// slope over stray points hides the table's own face; smaller: more candidates to rank.
  double same_plane_rad = base::Deg(1.0);
  double same_plane_share = 0.2;
  /// Points of the hull, evenly chosen. More: slower, strays bend it; fewer: it lies a bit higher.
  std::size_t hull_points = 2000;
  std::size_t ranking_points = 4000;  ///< rank candidates and hypotheses; finalists use all points
  std::size_t finalists = 5;
  double min_support = 0.05;      ///< smallest share of the points on a table
  double max_below = 0.01;        ///< largest share of the points below it
  int peelings = 4;               ///< how often the hull's vertices are removed as outliers
  int dominant_planes = 3;        ///< tried if the hull shows no table
  double dominant_support = 0.2;  ///< smallest share of the points on such a plane
};

/// Options of section 5.1.1 (and 4.2.1-4.2.2); defaults are the dissertation's for its scanner.
struct PreprocessOptions : PreprocessAdditions {
  /// Points this near to the deepest hull plane are fitted (5.1.1), because strays bend the hull.
  AdaptiveLength preselection_m{0.005, {.noises = 5.0}};
  int plane_draws = 100;                                    ///< section 5.1.1
  AdaptiveLength plane_distance_m{0.002, {.noises = 2.5}};  ///< 5.1.1: nearly all of a Gaussian
  /// A table of 200,000 points leaves a few dozen above five deviations where noise grows with
  /// distance; less cuts objects.
  AdaptiveLength table_clearance_m{0.004, {.noises = 5.0}};
  bool filter = true;  ///< the compression-rate filter, eq. 4.5-4.9
  /// Eq. 4.8 and 4.9 remove a point only if it is isolated, too. This is not an extension, but a
  /// reading of the text: as printed, they would remove a large part of a scan
  /// (CompressionRateFilter), and the dissertation removed 38 of 22,377 points.
  bool isolated_outliers = true;
  /// The unit of length of eq. 4.8: the dissertation's millimetre, half of its scanner's spacing.
  AdaptiveLength filter_unit_m{0.001, {.spacings = 0.34}};
  /// A point with a neighbor this near is no outlier. 0: as published, but the filter then removes
  /// half of an evenly sampled surface, where d_a, d_k and all distances are alike. Larger: strays.
  AdaptiveLength filter_keep_m{0.0, {.spacings = 1.3}};
  bool smooth = true;  ///< the average filter (section 5.1.1)
  /// Reaches the eight neighbors of an even scan. Larger rounds edges, so it grows with noise only.
  AdaptiveLength smooth_radius_m{0.003, {.noises = 3.0}};
  /// Radius for the normals (sections 4.2.2, 5.1.1): ten points of an even scan.
  AdaptiveLength normal_radius_m{0.005, {.noises = 5.0, .spacings = 1.7}};
  double max_widening = 4.0;  ///< of the radius, with widened_normals; larger rounds edges
  std::optional<Eigen::Vector3d> up_C;  ///< direction away from the table, if it is known
  TableSearchOptions table;
};

/// Top surfaces (section 5.1.3, eq. 5.5) and their rims.
struct TopSurfaceOptions {
  int plane_draws = 100;                                    ///< eq. 5.5
  AdaptiveLength plane_distance_m{0.002, {.noises = 2.5}};  ///< as for the table (section 5.1.1)
  /// Angle of a top's normals to the table's, 45 deg: their main component is along it (5.1.3).
  double normal_angle_rad = 0.785;
  int min_plane_points = 12;       ///< three rows of four. Larger: small lids are lost
  double min_upward_share = 0.04;  ///< share of a part's points; fewer are the rounding of an edge
  int planes = 3;  ///< searched for one above the fullest: a lip, a shoulder, a floor
  double plane_separation = 2.0;  ///< least distance between different planes, in plane distances
  /// Depth of the highest points that are used instead of a plane: the range of a plane's inliers.
  AdaptiveLength slab_m{0.004, {.noises = 5.0, .spacings = 1.35}};
  double fold_elongation = 4.0;  ///< a more elongated slab is a fold, a less elongated one a lip
  /// Alpha of the rim's 2-D shape. Smaller: holes between points; larger: a cup's mouth closes.
  AdaptiveLength rim_alpha_m{0.006, {.noises = 3.0, .gaps = 1.3}};
  AdaptiveLength bridged_rim_alpha_m{0.030, {.gaps = 6.5}};  ///< bridges gaps up to twice as wide
};

/// How a ridge is distinguished from a plane, the lip of a cup and a shoulder.
struct RidgeOptions {
  double window_rad = 1.15;        ///< around up: both sides of a roof of 60 deg, without walls
  double max_along_axis = 0.35;    ///< of normals across the axis (20 deg); others belong to ends
  double min_square_share = 0.8;   ///< share of the upward points; less means no common axis
  double max_mean_square = 0.045;  ///< mean square of the normals' part along the axis: 12 deg
  double max_axis_slope = 0.5;     ///< sine of the axis' slope (30 deg): a steeper body stands
  /// Spread of the middle 60 % of the normals: a plane has about 10 deg, a cylinder 45 deg or more.
  double min_spread_rad = 0.44;
  /// Correlation of sine and offset across it: a cup's near lip and far wall face the same way.
  double min_correlation = 0.7;
  /// Ratio of the ridge's length to the body's: a cap above a shoulder is not the shoulder's ridge.
  double min_length_share = 0.6;
  double off_ridge_rad = 0.45;  ///< points that face further off (26 deg) measure the descent
  /// Share of the descent of a circle with these normals: about 1 for a circle, 0.5 and more for a
  /// flat ellipse, next to nothing for a cup's lip, whose normals face all sides at one height.
  double min_drop_share = 0.35;
  double half_angle_rad = 0.35;  ///< angle of the strip's normals to the ridge's (20 deg)
};

/// Circles through rim points (eq. 5.6, 5.7).
struct CircleFitOptions {
  int draws = 100;  ///< as for the planes (eq. 5.5)
  AdaptiveLength distance_m{0.002, {.noises = 2.5, .spacings = 0.67}};  ///< eq. 5.6
  double max_radius_m = 0.15;  ///< tabletop objects have no wider circle
  int refits = 3;              ///< least-squares refits to the inliers; end if nothing is gained
  /// Share of inliers that a refit keeps. Not 1: a draw can have more than a least-squares fit.
  double refit_share = 0.98;
};

/// Whether a body is rotational, and about which axis (section 5.1.3, eq. 5.8).
struct AxisOptions {
  double rim_share = 0.8;   ///< share of the rim points on one circle (section 5.1.3)
  double body_share = 0.8;  ///< share of the points that agree with their section (section 5.1.3)
  /// Share of the points that agree and whose normals pass the axis. A round wall has 0.67 and more
  /// (normals at its outline turn towards the sensor), 29 generated bottles, cups and cylinders
  /// alone on the table 0.94 and more; a square column has a third, hexagons 0.59 to 0.74.
  double normal_share = 0.66;
  AdaptiveLength section_m{0.004, {.noises = 2.5, .spacings = 1.35}};  ///< thickness: two rows
  /// A short arc fits nearly any curve, so the rim has to cover this arc (twelve bins of ArcOf).
  double min_arc_rad = base::Deg(115.0);
  /// For a rim with bridged gaps, whose straight sides have few points (240 deg).
  double min_bridged_arc_rad = 4.2;
  double min_lying_arc_rad = 1.5;  ///< for a lying body (90 deg): at most half of it is seen
  double lying_body_share = 0.88;  ///< replaces body_share for it: ends and handles are not square
  /// No body is below the table; a fitted circle may reach this far below it.
  AdaptiveLength max_sunk_m{0.006, {.noises = 3.0, .gaps = 1.3}};
  /// Arc about the rim's axis: a round body shows 110 deg and more, a bottle's narrow side less.
  double min_body_arc_rad = base::Deg(90.0);
  int min_body_points = 20;             ///< fewer say nothing about the body
  double max_along_axis = 0.7;          ///< normals nearer to it (45 deg) are of caps, floors, lips
  double max_tangential = 0.34;         ///< of normals, sin(20 deg): noise, but no ends of ellipses
  double upright_rad = base::Deg(5.0);  ///< uncertainty from a small rim

  // Refinement by the body.
  int refine_rounds = 5;           ///< rounds of Gauss-Newton; each costs one pass over the body
  double max_shift_m = 0.004;      ///< more than a rim's grazing side can shift its circle
  double min_conditioning = 0.02;  ///< least eigenvalue of the normal matrix per point: 60 deg
  double top_sections_m = 0.012;   ///< the wall under a rounded rim that gives the radius

  // The axis from the body if the top is a thin ring, or a lid whose own rim gives no circle.
  double min_ring_arc_rad = base::Deg(105.0);  ///< arc of the ring's wall, mean over its sections
  /// Arc of the lid's rim: half a disc has 180 deg and a bin or two at its corners.
  double min_lid_arc_rad = base::Deg(205.0);
  /// Distance of the lid's rim from the body's circle: the rim is rounded.
  AdaptiveLength lid_distance_m{0.006, {.noises = 3.0, .gaps = 1.3}};
  double ring_share = 0.35;       ///< a top is a thin ring if it fills less than this of its circle
  double max_wall_m = 0.010;      ///< thickness of a cup's wall with its lip
  double ring_body_share = 0.6;   ///< replaces body_share for a ring: a handle may be in front
  int min_wall_points = 60;       ///< three sections' worth; half of them have to agree
  double min_normals_sine = 0.2;  ///< between two normals (12 deg): parallel ones meet anywhere
};

/// Clipped rotational parts (section 5.1.3) and fragments.
struct MergeOptions {
  // Cheap conditions before two parts are fitted as one rotational object: the uncertainty from rim
  // noise and from an axis of half a rim.
  double max_height_difference_m = 0.010;
  double max_center_distance_m = 0.010;
  /// Share of each part's points that could agree (of all, if the union has no rim). The body share
  /// applies to the union, as printed; the part with the handle may be below it.
  double min_own_body = 0.5;

  // Fragments (FindKinship).
  AdaptiveLength fragment_gap_m{0.012, {.noises = 6.0, .gaps = 2.6}};  ///< gap of lost points
  /// Gap between a round host and its cap or handle: a shoulder that turns away from the sensor.
  double hidden_gap_m = 0.030;
  AdaptiveLength footprint_margin_m{0.005, {.spacings = 1.7}};  ///< two and a half point spacings
  AdaptiveLength height_margin_m{0.003, {.noises = 3.0}};       ///< margin of "not above the top"
  double within_share = 0.7;  ///< share of a fragment's points over the footprint that it is in
  double cap_share = 0.8;     ///< share of a cap's points over the cross-section of its host
  /// The segmentation has cut between points this near: their parts are not joined as kSurface, but
  /// as kHanging. 0: it cuts nothing (perceive.cpp sets it).
  double cut_m = 0.0;
  /// Share of a hanging part's points under which the sensor saw through: a handle 20 mm over the
  /// table has 0.36, a thing that leans on a host next to none. Larger: handles become objects;
  /// smaller: leaning things become handles.
  double min_free_below = 0.25;
  double min_free_below_apart = 0.5;  ///< if it is not close to its host: handles had 0.69 and more
  /// Ratio of its points to its host's: 55 handles of twenty generated cups have 0.05 to 0.30, a
  /// third of them more than 0.2. Larger: leaning things are handles (11 things to 3 handles with
  /// 0.5, in 360 scans of clutter); smaller: handles are objects.
  double max_hanging_share = 0.3;
  // For a cap, as shares of its host's length and width: the necks of twenty generated bottles are
  // up to 0.41 as long and 0.65 as wide. Larger: small things in the middle of others become caps.
  double max_cap_length = 0.45;
  double max_cap_width = 0.7;
  double max_cap_offset = 0.15;  ///< of its middle from its host's, as occlusion shifts it
  /// Ratio of a piece's points to its host's, under the host's top. Larger: things under an object
  /// join it (13 above this to 4, in 480 scans; 3 to 4 below); smaller: crumbs become objects.
  double max_crumb_share = 0.05;
  int min_pairs = 8;  ///< point pairs across the gap; fewer occur between any two neighbors
  double min_continuing = 0.5;  ///< share of the pairs whose surfaces continue each other
  /// Distance in front of the other side's tangent plane: three times the noise.
  AdaptiveLength max_in_front_m{0.0015, {.noises = 3.0, .spacings = 0.5}};
  double max_sideways = 0.5;  ///< share of a gap across the sensor's viewing plane (30 deg)

  // Parts that touch nothing but each other (MergeLone). Larger: small things that stand together
  // or on each other are joined; smaller: toys, pliers and vases fall into parts. Of 56 scans of
  // single household things that were cut, 49 are whole again; of 203 heaps of several things in
  // clutter, 14 are joined.
  double max_lone_width_m = 0.10;  ///< what a hand can hold
  double max_lone_length_m = 0.25;
  double max_lone_height_m = 0.12;               ///< height of its top; stacks are higher
  double max_lone_crease_rad = base::Deg(55.0);  ///< mean angle of a concave edge between two parts
  // Limbs of the largest of such parts. Their edges may be sharp, and a shadow may separate them.
  double max_limb_m = 0.06;     ///< length and height; things that are grasped are larger
  double max_limb_share = 0.5;  ///< points, as a share of the body's; two small things are alike
  double limb_gap_m = 0.02;     ///< larger: things that stand beside each other are joined
  double max_limbed_width_m = 0.16;  ///< of a body with limbs only; a hand grasps the body
};

/// Open boxes that objects lie in (internal/container.h).
struct ContainerOptions {
  /// Distance from the box's border: wall thickness and noise. Larger: leaning things become wall.
  AdaptiveLength wall_m{0.008, {.noises = 3.0, .gaps = 2.0}};
  double piece_share = 0.9;  ///< share of a piece of wall within piece_walls * wall_m of the border
  double piece_walls = 1.5;
  double min_side_m = 0.15;  ///< wider than a hand opens; a narrower ring is a vessel to be grasped
  /// Share of the border seen as high as its rim; things in the box hide the rest. Of 40 scans of
  /// 20 generated boxes, 200 to 420 mm long and turned, with ten generated objects in them, 37 have
  /// more, 30 more than 0.75; of 40 heaps without a box none has over 0.58. Round pots have more.
  double min_coverage = 0.65;
  double max_upward = 0.5;  ///< part of an upright surface's normals along the table's normal
  /// Margin over the rim for noise; a height that differs from it by twice as much is not level.
  AdaptiveLength rim_margin_m{0.003, {.noises = 3.0}};
  double coverage_step_m = 0.010;  ///< step of the coverage count: two lines of a line scanner
  int min_end_points = 4;  ///< points within wall_m of a sheet's end; fewer are mixed points
  double max_lid = 0.5;    ///< a larger share of the box's area at rim height is a lid
  double direction_step_rad = base::Deg(2.0);  ///< bin of the histogram of the walls' directions
  int max_directions = 3;                      ///< maxima of the histogram that are tried
  int turn_rounds = 2;                         ///< rounds that refine a direction
};

/// Completion of the unseen sides (section 5.1.4).
struct CompletionOptions {
  double step_rad = 0.0872665;  ///< 5 deg (section 5.1.4)
  double mirror_share = 0.85;   ///< share of the mirrored points that must be in unseen space
  /// Distance from a free point to the points measured behind it; direction cells are 4 mm wide.
  AdaptiveLength free_margin_m{0.006, {.noises = 4.0, .spacings = 2.0}};
  double min_inclination_rad = 0.21;  ///< a top tilted further (12 deg) has an upper edge
  double max_top_share = 0.6;   ///< of the body's rectangle; a smaller top gives a half-turn image
  double min_elongation = 1.2;  ///< of a top surface that gives the object's direction
  /// A rectangle's side ends at the outermost point with this share of all points, and at least
  /// this many, in the band below it; points further out are mixed points.
  AdaptiveLength end_band_m{0.002, {.spacings = 0.67}};
  double end_share = 0.002;
  int min_end_points = 4;

  double wall_step_m = 0.005;  ///< between the posts of a wall, and between the points on a post
  /// Points this near to an outline's side determine the height of its wall.
  AdaptiveLength wall_outline_m{0.003, {.noises = 2.0, .spacings = 1.0}};
  AdaptiveLength cell_m{0.006, {.gaps = 1.3}};  ///< cell of the fill's grid: three point spacings
  double min_fill = 0.75;       ///< an outline that is filled less is not convex: several hulls
  double slice_m = 0.020;       ///< thickness of those hulls
  double slice_overlap = 0.15;  ///< share of a slice, so that neighbors leave no gap

  // Used if complete_leaning is on.
  double min_lean_rad = 0.14;       ///< of the top (8 deg): noise and the table's fit stay below
  double max_lean_rad = 1.13;       ///< a top that leans further (65 deg) is a side
  double min_lean_depth_m = 0.012;  ///< seen below the top, to give the object's thickness
  /// Points further outside the top's outline, seen along its normal, are on no face normal to it.
  AdaptiveLength lean_margin_m{0.006, {.noises = 4.0, .gaps = 1.0}};
  double max_lean_outside = 0.15;  ///< share of all points

  // Bodies of revolution.
  int sides = 36;              ///< sides of the surface: 0.4 % of the radius inside the circle
  double wall_m = 0.004;       ///< thickness of a wall or a cavity's floor seen from one side only
  int min_section_points = 3;  ///< sections with fewer are interpolated from their neighbors
  double min_floor_depth_m = 0.010;  ///< below the rim; higher points belong to the lip
  double min_floor_cosine = 0.8;     ///< cosine of a floor's normals with the axis (37 deg)
  int min_floor_points = 10;         ///< fewer are mixed points in the cavity
  double min_axis_cosine = 0.3;      ///< bounds the length of a leaning body (73 deg)
  /// A handle starts this far outside the circles, beyond their noise.
  AdaptiveLength attached_m{0.003, {.noises = 4.0, .spacings = 1.0}};
  AdaptiveLength link_m{0.006, {.noises = 3.0, .gaps = 1.3}};  ///< within one attachment
  int min_attached_points = 15;                                ///< fewer are stray points

  // A part stands on the table if it comes this low (the table's clearance is not in the cloud).
  AdaptiveLength on_table_m{0.012, {.noises = 10.0, .spacings = 4.0}};
  int min_support_points = 15;  ///< points of other parts under a footprint; fewer are stray points
};

struct FeatureAdditions {   // with the reason if the rows below do not give it
  bool ridge_tops = true;   ///< planes that touch a lying cylinder all have about as many points
  bool higher_tops = true;  ///< a container's floor or a shoulder can have more points than the rim
  bool slab_tops = true;
  bool level_tops = true;      ///< planes through stray points of a steep face lean like it
  bool rectangle_axes = true;  ///< a partial view turns the axes of the covariance
  bool arc_rule = true;        ///< short arcs fit any curve
  bool bridged_rims = true;    ///< lost points leave gaps
  bool upright_axes = true;
  bool radial_normals = true;
  bool refine_axis = true;      ///< the rim's far side is seen at a grazing angle
  bool axis_from_body = true;   ///< a cup's lip is as thin as profiles are apart; gloss breaks rims
  bool lying_axes = true;       ///< their top has no circle
  bool lip_tops = true;         ///< the floor of a bowl has more points than its lip
  bool merge_fragments = true;  ///< off: only clipped rotational parts are merged
  bool lone_objects = true;     ///< concave things are cut at their necks, and a scan shows no more
  /// Without it, a hand that closes on the seen half of a lying cylinder hits the other half.
  bool complete_by_symmetry = true;
  bool complete_leaning = true;  ///< leaning objects have no faces normal to the table
  bool trim_strays = true;       ///< mixed points
  bool drop_needles = true;      ///< needles are mixed points along one ray
  bool open_strays = true;  ///< mixed points hang between a container's near rim and its far wall
};
constexpr std::array<base::Addition<FeatureAdditions>, 20> AdditionsOf(const FeatureAdditions*) {
  using A = FeatureAdditions;
  return {{
      {"ridge_tops", &A::ridge_tops, "accept the ridge of a lying cylinder or of a roof as top"},
      {"higher_tops", &A::higher_tops,
       "use a plane above the largest one as top if it has 30 % of its points"},
      {"slab_tops", &A::slab_tops, "use the highest points as top if no plane has enough points"},
      {"level_tops", &A::level_tops, "a top leans at most 45 deg from the table"},
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
      {"drop_needles", &A::drop_needles, "remove objects narrower than 15 mm in both directions"},
      {"open_strays", &A::open_strays,
       "allow points in the sphere of an open object, 2 % of those of its top; off: none"},
  }};
}
static_assert(base::AllAdditionsListed<FeatureAdditions>());

/// Options of sections 5.1.3 and 5.1.4 and of the open/closed test of section 5.2. The switches of
/// its base class are the extensions beyond them.
struct FeatureOptions : FeatureAdditions {
  TopSurfaceOptions top;
  RidgeOptions ridge;
  CircleFitOptions circle;
  AxisOptions axis;
  MergeOptions merge;
  /// Used in both methods: the hand may hit a box (figure 5.17), but must not grasp it.
  bool containers = true;
  ContainerOptions container;
  CompletionOptions completion;

  double top_plane_share = 0.3;
  double min_footprint_m = 0.015;
  double open_sphere_factor = 2.0 / 3.0;  ///< eq. 5.9
  double open_stray_share = 0.02;         ///< share of the top surface's points
};

/// Largest noise that a user may give [m]: no range sensor that sees objects on a table has more,
/// so that a larger number is in another unit.
inline constexpr double kMaxNoise_m = 0.05;

struct PerceptionOptions {
  PreprocessOptions preprocess;
  SegmentOptions segment;
  FeatureOptions features;
  SamplingOptions sampling;
  std::optional<double> noise_m;  ///< the sensor's noise, if it is known [m]; else it is measured
  /// The noise is the median of the values that the observation states for its samples. For a
  /// sensor whose errors are constant over whole neighborhoods, which therefore do not show them.
  bool stated_noise = false;
};

/// Sets segment.min_points, and every AdaptiveLength that was not given, to what the sampling
/// requires.
void AdaptLengths(const Sampling& sampling, PerceptionOptions& options);

/// Reads all keys of the mapping `perception`.
/// @throws base::InputError
void ReadOptions(base::YamlMap map, PerceptionOptions& options);

}  // namespace rangegrasp::perception
