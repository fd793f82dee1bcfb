#pragma once

#include <optional>

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
  Indices landmark;
  Eigen::MatrixXd distance;  ///< a vertex a row, a landmark a column; infinite if not joined
  Indices nearest;           ///< a vertex: position in landmark
  double spacing = 0.0;      ///< the largest distance of a vertex to its nearest landmark
};
/// @throws std::invalid_argument without vertices or with count < 1.
LandmarkDistances SpreadLandmarks(const VertexGraph& graph, int count);
/// Symmetric: a path's length is rounded differently there and back; the mean is taken.
Eigen::MatrixXd BetweenLandmarks(const LandmarkDistances& spread);

/// Eq. 2.36-2.37 with all weights equal: U^+ B(X) X = B(X) X / N (the rows of B add up to zero, so
/// that the pseudoinverse's centring does nothing). Returns the stress of `positions` (eq. 2.33),
/// the sum over i < j of (d_ij(X) - delta_ij)^2. O(N^2).
double GuttmanTransform(const Eigen::MatrixXd& distances, const Eigen::MatrixX3d& positions,
                        Eigen::MatrixX3d& next);

/// Classical scaling (Torgerson 1952): the three leading eigenvectors of the doubly centered
/// squared distances, each times the root of its eigenvalue (0 where that is negative); the largest
/// entry of each is positive.
Eigen::MatrixX3d ClassicalScaling(const Eigen::MatrixXd& distances);

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

/// Places a point from its distances to embedded landmarks: the linear least squares of the squared
/// distances (de Silva and Tenenbaum 2004, landmark MDS), then `steps` times
/// x <- mean_i (X_i + delta_i (x - X_i) / |x - X_i|), the Guttman transform of one point with the
/// landmarks held, which lowers sum_i (|x - X_i| - delta_i)^2.
class LandmarkPlacement {
 public:
  explicit LandmarkPlacement(const Eigen::MatrixX3d& landmarks);
  Eigen::Vector3d Place(const Eigen::Ref<const Eigen::VectorXd>& distances, int steps) const;

 private:
  Eigen::MatrixX3d landmarks_;
  Eigen::MatrixX3d solve_;  ///< pseudoinverse, transposed
  Eigen::VectorXd squared_norms_;
  Eigen::Vector3d center_;
};

}  // namespace rangegrasp::parts
