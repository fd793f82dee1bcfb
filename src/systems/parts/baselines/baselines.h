#pragma once

#include <set>

#include "parts/shape/segmentation.h"
#include "parts/stretched/embedding.h"

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

// Steps of core extraction.

/// The coarse form in which core extraction looks at a mesh: landmarks, joined where their cells
/// touch.
struct LandmarkForm {
  LandmarkDistances spread;
  Eigen::MatrixXd distance;   ///< between landmarks
  geometry::Points embedded;  ///< the landmarks in their pose-invariant places
  std::vector<std::set<std::uint32_t>> neighbors;
  std::vector<bool> near_cut;  ///< a landmark: its cell holds a vertex at a cut

  std::uint32_t size() const { return static_cast<std::uint32_t>(spread.landmark.size()); }
};
/// @param cut  a vertex: on an edge where the mesh was cut from the rest.
LandmarkForm MakeLandmarkForm(const VertexGraph& graph, const std::vector<bool>& cut,
                              int landmarks);

/// Landmarks that are farther from all others, in the mean, than their neighbors are, lie on the
/// embedding's hull and not at a cut.
std::vector<bool> FeaturePoints(const LandmarkForm& form, const std::vector<bool>& on_hull);

/// What a cut along the edges of a mesh costs (Katz and Tal 2003): an edge's length over
/// 1 + a / mean(a), a = eta (1 - cos of the dihedral angle), eta = 1 for a concave and 0.2 for a
/// convex edge. Parallel to FaceGraph::neighbor.
std::vector<double> CutCosts(const Shape& mesh, const FaceGraph& faces);

/// Moves the boundary of the faces labelled `segment` to the cheapest place not farther from it
/// than `width`, along the surface: minimum cut between the segment's faces that are farther and
/// all others. Only faces of `segment` and of label 0 change.
void RefineBoundary(const Shape& mesh, const VertexGraph& graph, const FaceGraph& faces,
                    const std::vector<double>& costs, std::int32_t segment, double width,
                    Labels& label);

}  // namespace rangegrasp::parts
