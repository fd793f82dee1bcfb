#pragma once

#include <set>

#include "parts/stretched/embedding.h"

namespace rangegrasp::parts {

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
