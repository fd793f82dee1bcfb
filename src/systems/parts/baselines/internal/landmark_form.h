#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "geometry/point_cloud.h"
#include "parts/stretched/geodesic.h"

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

/// Feature points and core: a label a landmark, 0 the core, and how many others. None, and no
/// labels, where more than hull_fraction of the landmarks lie on their convex hull.
std::int32_t LabelLandmarks(const LandmarkForm& form, double hull_fraction,
                            std::vector<std::int32_t>& label);

}  // namespace rangegrasp::parts
