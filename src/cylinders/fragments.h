#pragma once

#include <vector>

#include "geometry/kd_tree.h"
#include "geometry/point_cloud.h"

/// Curvature points that hang together (section 4.2.3).
namespace rangegrasp::cylinders {

/// d_ca of eq. 4.15 [m]: the mean distance of a curvature point to its nearest other one. The
/// text's sum goes over the nearest neighbors of all m points, not over those of one. 0 for fewer
/// than two points.
double MeanNearestDistance(geometry::PointSpan points, const geometry::KdTree& tree);

struct FragmentOptions {
  /// Of d_ca: how near a point of a fragment is to another of it. 1 as published (eq. 4.17), which
  /// takes about half of all points off any fragment, since their nearest neighbor is further than
  /// the mean. Larger: fragments with gaps hold together, and those of touching objects, too.
  double link = 3.0;
  /// A fragment with fewer points says nothing of a circle.
  int min_points = 12;
};

/// Connected sets of points, each less than link d_ca from another of its set (eq. 4.16, 4.17):
/// what the recursive flood fill finds, by disjoint sets. Largest first, ties by first point;
/// positions ascending; those with too few points left out. O(n log n).
std::vector<geometry::Indices> Fragments(geometry::PointSpan points,
                                         const FragmentOptions& options);

}  // namespace rangegrasp::cylinders
