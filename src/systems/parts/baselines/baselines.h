#pragma once

#include <set>

#include "parts/shape/segmentation.h"
#include "parts/stretched/embedding.h"

namespace rangegrasp::parts {

inline constexpr int kDefaultClusters = 5;  ///< of k-means and, as in CGAL, of the diameters

struct KMeansOptions {
  int clusters = kDefaultClusters;  ///< >= 1
  double dihedral_weight = 1000.0;  ///< penalty for crossing a concave edge on the dual graph
  int iterations = 50;
};
/// K-means of faces (Shlafman et al. 2002, as run by Chen et al. 2009). It starts from k seeds far
/// apart and assigns each face to the nearest seed along the dual graph. A dual edge costs the
/// distance between centroids, increased by a penalty for the dihedral angle (Funkhouser et al.
/// 2004). Seeds then move to the middle of their clusters until nothing changes. Meshes only.
Segmentation SegmentByKMeans(const Shape& shape, const KMeansOptions& options);

/// Shape diameter function (Shapira et al. 2008) by CGAL, with its defaults. Meshes only.
/// @param clusters  >= 1
Segmentation SegmentBySdf(const Shape& shape, int clusters = kDefaultClusters);

/// Core extraction (Katz et al. 2005): MDS, feature points, core by mirroring, hierarchy,
/// refinement by minimum cuts. Meshes only.
/// @param levels  >= 1, of the hierarchy
Segmentation SegmentByCoreExtraction(const Shape& shape, int levels = 2);

// Steps of core extraction.

/// Coarse representation of a mesh for core extraction: landmarks, linked where their cells touch.
struct LandmarkForm {
  LandmarkDistances spread;
  Eigen::MatrixXd distance;   ///< between landmarks
  geometry::Points embedded;  ///< landmark positions in the pose-invariant embedding
  std::vector<std::set<std::uint32_t>> neighbors;
  std::vector<bool> near_cut;  ///< per landmark: true if its cell contains a vertex at a cut

  std::uint32_t size() const { return static_cast<std::uint32_t>(spread.landmark.size()); }
};
/// @param cut  per vertex: true if it lies on an edge where the mesh was cut from the rest
LandmarkForm MakeLandmarkForm(const VertexGraph& graph, const std::vector<bool>& cut,
                              int landmarks);

/// Feature points: landmarks whose mean distance to all others is larger than that of their
/// neighbors, that lie on the hull of the embedding and not at a cut.
std::vector<bool> FeaturePoints(const LandmarkForm& form, const std::vector<bool>& on_hull);

/// Cost of a cut along each edge of a mesh (Katz and Tal 2003): the edge length divided by 1 + a /
/// mean(a), where a = eta (1 - cos(dihedral angle)), and eta is 1 for a concave and 0.2 for a
/// convex edge. Parallel to FaceGraph::neighbor.
std::vector<double> CutCosts(const Shape& mesh, const FaceGraph& faces);

/// Moves the boundary of the faces labelled `segment` to the cheapest place within `width` of it
/// along the surface. A minimum cut separates the segment's faces that are farther away from all
/// other faces that keep their labels. Only faces of `segment` and of label 0 change.
void RefineBoundary(const Shape& mesh, const VertexGraph& graph, const FaceGraph& faces,
                    const std::vector<double>& costs, std::int32_t segment, double width,
                    Labels& label);

}  // namespace rangegrasp::parts
