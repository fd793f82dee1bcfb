#pragma once

#include <optional>

#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {

/// Straight distance between c and d after unfolding the triangles (a, b, c) and (b, a, d) into a
/// plane; nullopt if the line leaves the triangles, i.e. does not cross the edge a-b.
std::optional<double> UnfoldedDistance(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                       const Eigen::Vector3d& c, const Eigen::Vector3d& d);

/// The vertex graph, for a mesh with an additional link across every edge (UnfoldedDistance).
/// Separate pieces get their shortest link to the largest one, so that all distances are finite.
VertexGraph GeodesicGraph(const Shape& shape);

/// Landmarks: vertices far from each other, with the distances computed when picking them.
/// Farthest-point sampling along the graph starts from the vertex farthest from vertex 0, so that
/// nothing is random. There are fewer than requested if no vertex at a distance is left.
struct LandmarkDistances {
  Indices landmark;
  Eigen::MatrixXd distance;  ///< row: vertex, column: landmark; infinite if not connected
  Indices nearest;           ///< per vertex: index in landmark
  double spacing = 0.0;      ///< the largest distance of a vertex to its nearest landmark
};
LandmarkDistances SpreadLandmarks(const VertexGraph& graph, int count);
/// Symmetric: the mean of both directions, in which a path's length is rounded differently.
Eigen::MatrixXd BetweenLandmarks(const LandmarkDistances& spread);

/// Eq. 2.36-2.37 with equal weights: U^+ B(X) X = B(X) X / N (the rows of B sum to zero, so that
/// the pseudoinverse's centring has no effect). Returns the stress of `positions` (eq. 2.33), the
/// sum over i < j of (d_ij(X) - delta_ij)^2. O(N^2).
double GuttmanTransform(const Eigen::MatrixXd& distances, const Eigen::MatrixX3d& positions,
                        Eigen::MatrixX3d& next);

/// Classical scaling (Torgerson 1952): the three leading eigenvectors of the doubly centered
/// squared distances, each times the square root of its eigenvalue (0 if that is negative). The
/// largest entry of each is positive.
Eigen::MatrixX3d ClassicalScaling(const Eigen::MatrixXd& distances);

struct SmacofOptions {
  int iterations = 60;      ///< maximum, >= 1
  double tolerance = 1e-4;  ///< stops if the relative decrease of stress is smaller
};
struct Embedding {
  Eigen::MatrixX3d positions;
  std::vector<double> stress;  ///< after each iteration; never increases (eq. 6.9, 2.33)
};
/// SMACOF (eq. 2.33-2.37), which starts from ClassicalScaling.
Embedding Smacof(const Eigen::MatrixXd& distances, const SmacofOptions& options);

/// Places a point by its distances to embedded landmarks. It starts with linear least squares of
/// the squared distances (de Silva and Tenenbaum 2004, landmark MDS). Then follow `steps`
/// iterations of x <- mean_i (X_i + delta_i (x - X_i) / |x - X_i|), the Guttman transform of one
/// point with fixed landmarks, which reduces sum_i (|x - X_i| - delta_i)^2.
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

/// The pose-invariant form of a shape (section 6.2.3): the same elements at other positions.
/// Landmarks are embedded by SMACOF; other points are placed by their geodesic distances to them.
/// @param landmarks  >= 4; shapes with fewer points use all of them. More landmarks embed a shape
///                   more exactly, at quadratic cost.
Shape PoseInvariant(const Shape& shape, int landmarks = 400);

}  // namespace rangegrasp::parts
