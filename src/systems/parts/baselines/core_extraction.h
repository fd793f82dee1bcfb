#pragma once

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

struct CoreExtractionOptions {
  /// >= 1; of the whole; a part has as many as the root of its share of faces. More find smaller
  /// feature points and cost their square.
  int landmarks = 300;
  int levels = 2;  ///< >= 1; of hierarchy
  /// A part stays whole when more of its landmarks lie on their convex hull.
  double hull_fraction = 0.7;
  /// >= 1; a part with fewer landmarks is not looked at: its few cells show no limbs.
  int min_landmarks = 16;
  /// How far a boundary may move to its cheapest place, in distances between landmarks. Less
  /// leaves it near the border between two cells, more may find a crease of another part.
  double boundary_reach = 6.0;
};
/// Katz et al. 2005: MDS, feature points, core by mirroring, hierarchical, minimum-cut refinement.
/// Meshes only.
Segmentation SegmentByCoreExtraction(const Shape& shape, const CoreExtractionOptions& options);

}  // namespace rangegrasp::parts
