#pragma once

#include <vector>

#include "geometry/kd_tree.h"
#include "geometry/point_cloud.h"

/// Curvature points that hang together (section 4.2.3).
namespace rangegrasp::cylinders {

/// The mean distance of a point to its nearest other one [m]; 0 for fewer than two points. One
/// reading of d_ca ("the average distance between all m curvature points, calculated by nearest
/// neighbor searching"): about half of all points are further than that from every other, so that
/// eq. 4.17 with it leaves no fragments.
double MeanNearestDistance(geometry::PointSpan points, const geometry::KdTree& tree);

/// d_ca of eq. 4.15 as its sum stands [m]: of a point's distances to its m neighbors within
/// radius_m, the neighborhood of eq. 4.13, and the mean of that over all points that have any. 0 if
/// none has.
double MeanNeighborDistance(geometry::PointSpan points, const geometry::KdTree& tree,
                            double radius_m);

struct FragmentOptions {
  /// How near a point of a fragment is to another of it, in mean nearest distances; 0: nearer than
  /// d_ca, as published (eq. 4.17). Larger: fragments with gaps hold together, and those of
  /// touching objects, too.
  double link = 3.0;
  /// The neighborhood of d_ca (section 4.2.3).
  double neighborhood_m = 0.005;
  /// A fragment with fewer points says nothing of a circle.
  int min_points = 12;
};

/// The distance below which two points are of one fragment [m].
double LinkDistance(geometry::PointSpan points, const geometry::KdTree& tree,
                    const FragmentOptions& options);

/// Connected sets of points, each less than LinkDistance from another of its set (eq. 4.16, 4.17):
/// what the recursive flood fill finds, by disjoint sets. Largest first, ties by first point;
/// positions ascending; those with too few points left out. O(n log n).
std::vector<geometry::Indices> Fragments(geometry::PointSpan points,
                                         const FragmentOptions& options);

}  // namespace rangegrasp::cylinders
