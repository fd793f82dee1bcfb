#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/units.h"
#include "perception/additions.h"
#include "perception/sampling.h"

namespace rangegrasp::perception {

/// How the table is looked for on the hull (see find_table.h). Defaults without a source are this
/// program's own.
struct TableSearchOptions {
  /// How far the table's normal may be from a given up direction: a hand-held estimate's error.
  double max_tilt_rad = base::Deg(15.0);
  /// Two faces of the hull are one plane if their normals agree this well, and the center of one
  /// lies this near the other, as a share of the preselection. Larger: a slope over stray points
  /// hides the table's own face; smaller: more candidates to rank.
  double same_plane_rad = base::Deg(1.0);
  double same_plane_share = 0.2;
  /// The hull is built over about this many of the points, evenly taken; all later steps that
  /// decide look at all. More: slower, and more strays that bend the hull; fewer: a hull that lies
  /// a little higher, within what the preselection spans.
  std::size_t hull_points = 2000;
  /// Candidates and hypotheses are ranked on about this many of the points, the best on all.
  std::size_t ranking_points = 4000;
  std::size_t finalists = 5;
  /// A table holds at least this share of the points, and at most that share may lie under it.
  double min_support = 0.05;
  double max_below = 0.01;
  /// How often the hull's vertices are taken away as outliers; each time costs a hull.
  int peelings = 4;
  /// Where the hull shows no table (a background behind and under it), the dominant plane is tried,
  /// and the next ones after it; it must hold this share of the points.
  int dominant_planes = 3;
  double dominant_support = 0.2;
};

/// Options of section 5.1.1 (and 4.2.1-4.2.2); defaults are the dissertation's for its scanner.
struct PreprocessOptions : PreprocessAdditions {
  /// Distance to the deepest hull plane; points nearer are fitted (section 5.1.1). The hull is bent
  /// by strays, so more than the band of the table's points.
  AdaptiveLength preselection_m{0.005, {.noises = 5.0}};
  int plane_draws = 100;  ///< section 5.1.1
  /// Inliers of the table plane (section 5.1.1): nearly all of a normal distribution.
  AdaptiveLength plane_distance_m{0.002, {.noises = 2.5}};
  /// Points lower than this above the table belong to it (see docs/architecture.md). A table of
  /// 200,000 points leaves a few dozen above five deviations where noise grows with distance; less
  /// cuts objects.
  AdaptiveLength table_clearance_m{0.004, {.noises = 5.0}};
  bool filter = true;  ///< the compression-rate filter, eq. 4.5-4.9
  /// Eq. 4.8 and 4.9 remove a point only where it is isolated, too. No addition, but how the text
  /// is read: as printed they would remove a large part of a scan (see point_filter.h), and the
  /// dissertation removed 38 of 22,377 points.
  bool isolated_outliers = true;
  /// The unit of length of eq. 4.8: the dissertation's millimetre, half of its scanner's spacing.
  AdaptiveLength filter_unit_m{0.001, {.spacings = 0.34}};
  /// A point with a neighbor this near is no outlier. 0: as published; but where points are evenly
  /// spaced, d_a, d_k and every nearest distance are about the same, and the filter takes half of a
  /// surface away. Larger: strays stay.
  AdaptiveLength filter_keep_m{0.0, {.spacings = 1.3}};
  bool smooth = true;  ///< the average filter (section 5.1.1)
  /// One and a half point spacings: the eight neighbors of an even scan. Larger rounds edges more,
  /// so that it grows with noise alone: what a coarse sensor measures needs no smoothing.
  AdaptiveLength smooth_radius_m{0.003, {.noises = 3.0}};
  /// Neighborhood of the normals (sections 4.2.2, 5.1.1): ten points of an even scan.
  AdaptiveLength normal_radius_m{0.005, {.noises = 5.0, .spacings = 1.7}};
  /// With widened_normals: how many times its radius a neighborhood grows to at most. Larger: more
  /// grazing faces have true normals, and more edges are rounded there.
  double max_widening = 4.0;
  /// The direction away from the table where it is known; else the hull plane that the most points
  /// lie near is taken.
  std::optional<Eigen::Vector3d> up_C;
  TableSearchOptions table;
};

}  // namespace rangegrasp::perception
