#pragma once

#include <array>

#include "base/additions.h"

/// What perception does beyond the dissertation; every switch off is the method as published
/// (core/additions.h). The reason for each stands beside it in docs/results.md.
namespace rangegrasp::perception {

struct PreprocessAdditions {
  /// Measures noise and spacing and adapts the lengths that stand for one of them; off: the
  /// published lengths, those of the dissertation's scanner.
  bool adapt_lengths = true;
  bool robust_table = true;
  bool repeated_filter = true;
  bool neighborhood_normals = true;
  /// A neighborhood that lies on one line of a scanner says nothing across the line: there, on
  /// faces seen at a grazing angle, it grows to max_widening times its radius.
  bool widened_normals = true;
};
constexpr std::array<base::Addition<PreprocessAdditions>, 5> AdditionsOf(
    const PreprocessAdditions*) {
  using A = PreprocessAdditions;
  return {{
      {"adapt_lengths", &A::adapt_lengths,
       "noise and spacing are measured and lengths adapted to them; off: the published lengths"},
      {"robust_table", &A::robust_table,
       "the table is looked for again without the hull's vertices, and as the fullest plane, where "
       "stray points hide it"},
      {"repeated_filter", &A::repeated_filter,
       "the outlier filter repeats until it finds none: far outliers hide nearer ones"},
      {"neighborhood_normals", &A::neighborhood_normals,
       "normals from the points within normal_radius_mm; off: of the faces of the segments' mesh"},
      {"widened_normals", &A::widened_normals,
       "with neighborhood_normals: from further off where those points all lie on one line"},
  }};
}
static_assert(base::AllAdditionsListed<PreprocessAdditions>());

struct SegmentAdditions {
  bool bounded_alpha = true;
  bool drop_small_segments = true;
};
constexpr std::array<base::Addition<SegmentAdditions>, 2> AdditionsOf(const SegmentAdditions*) {
  using A = SegmentAdditions;
  return {{
      {"bounded_alpha", &A::bounded_alpha,
       "bounds on the mesh's alpha, so that one straggler cannot join all; off: d_max as it is"},
      {"drop_small_segments", &A::drop_small_segments, "segments of less than 40 points are noise"},
  }};
}
static_assert(base::AllAdditionsListed<SegmentAdditions>());

struct FeatureAdditions {
  /// Where the highest part curves about a lying axis, take the strip along its ridge: every plane
  /// touching a lying cylinder holds about as many points, so eq. 5.5 alone would tip at random.
  bool ridge_tops = true;
  /// The floor of a container, or a shoulder, can hold more points than the rim above.
  bool higher_tops = true;
  /// The highest points stand in for a top surface where no plane holds enough points.
  bool slab_tops = true;
  /// The principal axis of a top surface from the least rectangle round it: the covariance of a
  /// surface that is seen in part, or nearly square, turns with what is missing.
  bool rectangle_axes = true;
  /// A circle that the rim, or the body, goes round by little says little: short arcs fit any
  /// curve.
  bool arc_rule = true;
  /// A second try with a rim whose ring has gaps of lost points.
  bool bridged_rims = true;
  /// An axis within a few degrees of the vertical is tried as upright.
  bool upright_axes = true;
  /// The normals of a rotational body pass its axis.
  bool radial_normals = true;
  /// The body corrects the rim's circle, whose far side is seen at a grazing angle.
  bool refine_axis = true;
  /// Where the rim gives no circle, find the axis from the body's normals, and merge clipped parts
  /// by it: the lip of a cup is as wide as the profiles are apart, so its rim has too few points,
  /// and gloss tears holes into the rim of a tin.
  bool axis_from_body = true;
  /// Rotational bodies that lie: their top has no circle.
  bool lying_axes = true;
  /// Where no axis is found, look for one from the object's highest points: the floor of a bowl
  /// holds more of them than its lip.
  bool lip_tops = true;
  /// Joins parts of one object that lost points have separated; off: only clipped rotational parts
  /// are merged.
  bool merge_fragments = true;
  /// Mirrors what is seen of ridges and of bodies wider than their tops into space that the sensor
  /// did not see through. Without it the far half of a lying cylinder is missing and a hand that
  /// closes on the seen half meets the other.
  bool complete_by_symmetry = true;
  /// Closes an object whose top leans by planes square to the top; off: square to the table. What
  /// leans on something else has no faces square to the table, and a hand that closes on those
  /// meets the object's real ones at a slant.
  bool complete_leaning = true;
  /// Mixed points that hang off an object's ends singly are no part of its completed shape.
  bool trim_strays = true;
  /// A part whose footprint is nowhere long is a needle of mixed points along one ray.
  bool drop_needles = true;
  /// The walls of an open box that objects lie in are obstacles, and no objects.
  bool containers = true;
  /// A few points inside the sphere of eq. 5.9 are taken for none: mixed points hang between the
  /// near rim of a container and its far wall.
  bool open_strays = true;
};
constexpr std::array<base::Addition<FeatureAdditions>, 19> AdditionsOf(const FeatureAdditions*) {
  using A = FeatureAdditions;
  return {{
      {"ridge_tops", &A::ridge_tops, "a lying cylinder's or roof's ridge is a top"},
      {"higher_tops", &A::higher_tops,
       "a plane above the fullest one is the top if it holds top_plane_share of its points"},
      {"slab_tops", &A::slab_tops,
       "the highest points stand in for a top where no plane has enough points"},
      {"rectangle_axes", &A::rectangle_axes,
       "a top's principal axis is that of the least rectangle; off: of its covariance"},
      {"arc_rule", &A::arc_rule,
       "a circle counts only where the rim goes round by a third and the body by a quarter"},
      {"bridged_rims", &A::bridged_rims, "rims are tried again with their gaps bridged"},
      {"upright_axes", &A::upright_axes, "a nearly upright axis is tried as upright"},
      {"radial_normals", &A::radial_normals,
       "points agree with a rotation axis only where their normals pass it"},
      {"refine_axis", &A::refine_axis, "the body corrects the rim's circle"},
      {"axis_from_body", &A::axis_from_body,
       "find an axis from the walls where the rim gives no circle: thin lips, lids with holes"},
      {"lying_axes", &A::lying_axes, "find rotational bodies that lie on their side"},
      {"lip_tops", &A::lip_tops, "find the axis of bowls from their lips"},
      {"merge_fragments", &A::merge_fragments, "join segments of one object"},
      {"complete_by_symmetry", &A::complete_by_symmetry,
       "mirror the surface of objects that are not rotational"},
      {"complete_leaning", &A::complete_leaning,
       "close objects that lean square to their top; off: square to the table"},
      {"trim_strays", &A::trim_strays,
       "single points off an object's ends are left out of its completed shape"},
      {"drop_needles", &A::drop_needles,
       "objects that are narrower than min_footprint_mm both ways are left out"},
      {"containers", &A::containers,
       "the walls of an open box are obstacles; off: objects like any other"},
      {"open_strays", &A::open_strays,
       "open_stray_share of the points may lie in the sphere of an open object; off: none"},
  }};
}
static_assert(base::AllAdditionsListed<FeatureAdditions>());

}  // namespace rangegrasp::perception
