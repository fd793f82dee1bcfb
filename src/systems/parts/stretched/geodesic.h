#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {

/// The straight distance between c and d with the triangles (a, b, c) and (b, a, d) laid flat;
/// nullopt if the line leaves them, that is, does not cross the edge a-b.
std::optional<double> UnfoldedDistance(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                       const Eigen::Vector3d& c, const Eigen::Vector3d& d);

/// The vertex graph with, for a mesh, a link across every edge (UnfoldedDistance); pieces that are
/// not joined get their shortest link to the largest one, so that all distances are finite.
VertexGraph GeodesicGraph(const Shape& shape);

/// Vertices far from each other, with what picking them found on its way: farthest-point sampling
/// along the graph from the vertex farthest from vertex 0, so that nothing is random. Fewer than
/// asked for where no vertex is left at a distance.
struct LandmarkDistances {
  std::vector<std::uint32_t> landmark;
  Eigen::MatrixXd distance;  ///< a vertex a row, a landmark a column; infinite if not joined
  std::vector<std::uint32_t> nearest;  ///< a vertex: position in landmark
  double spacing = 0.0;                ///< the largest distance of a vertex to its nearest landmark
};
/// @throws std::invalid_argument without vertices or with count < 1.
LandmarkDistances SpreadLandmarks(const VertexGraph& graph, int count);
/// Symmetric: a path's length is rounded differently there and back; the mean is taken.
Eigen::MatrixXd BetweenLandmarks(const LandmarkDistances& spread);

}  // namespace rangegrasp::parts
