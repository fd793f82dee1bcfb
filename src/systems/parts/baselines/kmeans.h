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

}  // namespace rangegrasp::parts
