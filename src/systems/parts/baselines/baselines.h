#pragma once

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
  int clusters = 5;  ///< >= 1; CGAL's default, as is all else
};
/// Shape diameter function (Shapira et al. 2008) by CGAL. Meshes only.
Segmentation SegmentBySdf(const Shape& shape, const SdfOptions& options);

struct CoreExtractionOptions {
  int levels = 2;  ///< >= 1; of hierarchy
};
/// Katz et al. 2005: MDS, feature points, core by mirroring, hierarchical, minimum-cut refinement.
/// Meshes only.
Segmentation SegmentByCoreExtraction(const Shape& shape, const CoreExtractionOptions& options);

}  // namespace rangegrasp::parts
