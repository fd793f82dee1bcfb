#pragma once

#include "base/units.h"
#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

struct KMeansOptions {
  int clusters = 5;                 ///< >= 1
  double dihedral_weight = 1000.0;  ///< penalty of crossing a concave edge on the dual graph
  int iterations = 50;
};
/// Shlafman et al. 2002 as Chen et al. 2009 ran it: k seeds far from each other, faces to the
/// nearest seed along the dual graph, whose edges cost the distance between centroids and a penalty
/// by the dihedral angle (Funkhouser et al. 2004), seeds to the middle of their clusters, until
/// nothing changes. Meshes only. @throws base::InputError for a cloud.
Segmentation SegmentByKMeans(const Shape& shape, const KMeansOptions& options);

struct SdfOptions {
  int clusters = 5;  ///< CGAL's defaults
  double smoothing = 0.26;
  int rays = 25;
  double cone_rad = 2.0 / 3.0 * base::kPi;
};
/// Shape diameter function (Shapira et al. 2008) by CGAL. Meshes only.
Segmentation SegmentBySdf(const Shape& shape, const SdfOptions& options);

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
