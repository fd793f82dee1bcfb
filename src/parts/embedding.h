#pragma once

#include <Eigen/Core>
#include <vector>

#include "parts/mirror.h"
#include "parts/shape.h"

namespace rangegrasp::parts {

/// Geodesic distances along a graph from `sources` (rows) to all vertices (columns), by Dijkstra.
Eigen::MatrixXd GeodesicDistances(const VertexGraph& graph,
                                  const std::vector<std::uint32_t>& sources);
/// `count` vertices far from each other: farthest-point sampling along the graph; starts from the
/// vertex farthest from vertex 0, so that nothing is random.
std::vector<std::uint32_t> FarthestPoints(const VertexGraph& graph, int count);

struct SmacofOptions {
  int iterations = 60;      ///< >= 1, at most
  double tolerance = 1e-4;  ///< stops when stress falls by less, relatively
};
struct Embedding {
  Eigen::MatrixX3d positions;
  std::vector<double> stress;  ///< after each iteration: never rises (eq. 6.9, 2.33)
};
/// Eq. 2.33-2.37 (SMACOF) from a start; by default classical scaling of the distances.
Embedding Smacof(const Eigen::MatrixXd& distances, const SmacofOptions& options,
                 const Eigen::MatrixX3d* start = nullptr);

struct PoseInvariantOptions {
  int landmarks = 400;  ///< >= 4; shapes with fewer points take all
  SmacofOptions smacof;
  MirrorOptions mirror;
  double core_growth = 1.6;  ///< >= 1; the core's hull grows up to this; 1: as the chapter has it
};
/// The shape in its pose-invariant form (section 6.2.3): landmarks are embedded by SMACOF, the
/// other points placed from their geodesic distances to landmarks. Same elements, other positions.
Shape PoseInvariant(const Shape& shape, const PoseInvariantOptions& options);
/// Segments the pose-invariant form by mirroring; the labels hold for the shape. Beyond the
/// chapter: the core's hull of a mesh grows about its middle, as Katz et al. (2005) let their core
/// grow, to the size where most parts with a hundredth of the faces or more come off; the smallest
/// such.
/// @throws std::invalid_argument if core_growth is below 1, and what SegmentByMirroring throws.
Segmentation SegmentPoseInvariant(const Shape& shape, const PoseInvariantOptions& options);

}  // namespace rangegrasp::parts
