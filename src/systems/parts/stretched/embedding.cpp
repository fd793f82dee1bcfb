#include "parts/stretched/embedding.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/graph.h"
#include "geometry/kd_tree.h"

namespace rangegrasp::parts {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixX3d;
using Eigen::MatrixXd;
using geometry::kFar;

std::uint32_t Opposite(const Face& face, const Edge& edge) {
  for (const std::uint32_t v : face) {
    if (v != edge[0] && v != edge[1]) return v;
  }
  return face[0];
}

/// The shortest link from each other piece to the largest one.
std::vector<VertexLink> LinksToLargest(const VertexGraph& graph, const Points& points) {
  const auto& [piece, pieces] = ConnectedPieces(graph, AnyNeighbors);
  if (pieces < 2) return {};
  const Indices index = geometry::PositionsWhere(piece, [](std::int32_t p) { return p == 0; });
  const Points largest = geometry::Select(points, index);
  const geometry::KdTree tree(largest);
  std::vector<geometry::KdTree::Neighbor> found;
  std::vector<VertexLink> links(pieces - 1, {0, 0, kFar});
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    if (piece[v] == 0) continue;
    tree.Nearest(points[v], 1, found);
    const double length = std::sqrt(found.front().squared_distance);
    VertexLink& link = links[piece[v] - 1];
    if (length < link.length) link = {v, index[found.front().index], length};
  }
  return links;
}

/// Up to this number of points all eigenvectors are computed, at cubic cost; above it only the
/// leading ones.
constexpr Index kMaxDense = 200;
/// Columns of the subspace in which three eigenvectors are searched for, and steps. In each step
/// the error of an eigenvalue shrinks by its ratio to the first one outside of the subspace. More
/// columns or steps cost time; fewer make the start of SMACOF rougher.
constexpr Index kSubspace = 12;
constexpr int kSubspaceSteps = 40;

/// -1/2 J D^2 J with J = I - 1 1^T / N.
MatrixXd DoublyCentered(const MatrixXd& distances) {
  MatrixXd b = -0.5 * distances.array().square();
  const Eigen::VectorXd row = b.rowwise().mean();
  const Eigen::RowVectorXd column = b.colwise().mean();
  const double all = row.mean();
  b.colwise() -= row;
  b.rowwise() -= column;
  b.array() += all;
  return b;
}

/// Coordinates from the three largest eigenvalues (given in ascending order) and their vectors.
MatrixX3d Coordinates(const Eigen::VectorXd& values, const MatrixXd& vectors) {
  MatrixX3d x = MatrixX3d::Zero(vectors.rows(), 3);
  for (Index k = 0; k < std::min<Index>(3, values.size()); ++k) {
    const Index from = values.size() - 1 - k;
    Eigen::VectorXd v = vectors.col(from) * std::sqrt(std::max(0.0, values[from]));
    Index largest = 0;
    v.cwiseAbs().maxCoeff(&largest);
    x.col(k) = v[largest] < 0.0 ? Eigen::VectorXd(-v) : v;
  }
  return x;
}

/// Orthogonal iteration that starts from columns of b, so that nothing is random.
MatrixX3d LeadingCoordinates(const MatrixXd& b) {
  MatrixXd q = b.leftCols(kSubspace);
  for (int step = 0; step < kSubspaceSteps; ++step) {
    const Eigen::HouseholderQR<MatrixXd> qr(q);
    q.noalias() = b * (qr.householderQ() * MatrixXd::Identity(b.rows(), kSubspace));
  }
  const Eigen::HouseholderQR<MatrixXd> qr(q);
  q = qr.householderQ() * MatrixXd::Identity(b.rows(), kSubspace);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> ritz(q.transpose() * b * q);
  return Coordinates(ritz.eigenvalues(), q * ritz.eigenvectors());
}

/// sum_i (x - X_i) delta_i / |x - X_i|, excluding points at x.
/// @param d  output, |x - X_i|
template <class Deltas>
Eigen::Vector3d PullOf(const MatrixX3d& points, const Eigen::Vector3d& x, const Deltas& delta,
                       ArrayXd& d) {
  const ArrayXd dx = x[0] - points.col(0).array();
  const ArrayXd dy = x[1] - points.col(1).array();
  const ArrayXd dz = x[2] - points.col(2).array();
  d = (dx.square() + dy.square() + dz.square()).sqrt();
  const ArrayXd ratio = (d > 0.0).select(delta / d, 0.0);
  return {(ratio * dx).sum(), (ratio * dy).sum(), (ratio * dz).sum()};
}

/// Majorisation steps per point. Measured on four-legged and armadillo models: all landmarks and 10
/// steps come within 1 % of the stress of 30 steps. The linear placement alone has 35-90 % more
/// stress; the nearest landmarks alone, or interpolation between them, give a rough surface.
constexpr int kPlacementSteps = 10;

}  // namespace

std::optional<double> UnfoldedDistance(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                       const Eigen::Vector3d& c, const Eigen::Vector3d& d) {
  const double length = (b - a).norm();
  if (!(length > 0.0)) return std::nullopt;
  const Eigen::Vector3d along = (b - a) / length;
  const double c_along = along.dot(c - a);
  const double d_along = along.dot(d - a);
  const double c_up = (c - a - c_along * along).norm();
  const double d_up = (d - a - d_along * along).norm();
  if (!(c_up + d_up > 0.0)) return std::nullopt;
  const double crossing = c_along + (d_along - c_along) * c_up / (c_up + d_up);
  if (!(crossing > 0.0 && crossing < length)) return std::nullopt;
  return std::hypot(d_along - c_along, c_up + d_up);
}

// Measured on the four-legged and armadillo models against paths that may bend at three more points
// on each edge. Along edges only, distances are 4-5 % too long and vary by 0.7-2.5 %; with the
// diagonals it is 0.7-1.0 % and 0.2-0.5 %, for twice the links. A uniform factor does no harm here,
// a varying one distorts the embedding.
VertexGraph GeodesicGraph(const Shape& shape) {
  const VertexGraph graph = BuildVertexGraph(shape);
  std::vector<VertexLink> links = LinksToLargest(graph, shape.points);
  const FaceGraph faces = BuildFaceGraph(shape);
  const Points& p = shape.points;
  ForEachLink(faces, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
    if (g < f) return;
    const auto& [a, b] = faces.edge[k];
    const std::uint32_t c = Opposite(shape.faces[f], faces.edge[k]);
    const std::uint32_t d = Opposite(shape.faces[g], faces.edge[k]);
    if (c == d) return;
    const auto length = UnfoldedDistance(p[a], p[b], p[c], p[d]);
    if (length) links.push_back({c, d, *length});
  });
  ForEachLink(graph, [&](std::uint32_t v, std::uint32_t w, std::uint32_t k) {
    if (v < w) links.push_back({v, w, graph.length[k]});
  });
  return GraphOfLinks(graph.Size(), std::move(links));
}

LandmarkDistances SpreadLandmarks(const VertexGraph& graph, int count) {
  const std::uint32_t n = graph.Size();
  std::vector<double> from = geometry::DistancesFrom({{0U}}, graph.Links());

  LandmarkDistances result;
  const std::uint32_t wanted = std::min(n, static_cast<std::uint32_t>(count));
  result.distance.resize(n, wanted);
  result.nearest.assign(n, 0);
  std::vector<double> nearest(n, kFar);
  std::uint32_t next = geometry::FarthestReached(from);
  while (result.landmark.size() < wanted) {
    const auto k = static_cast<std::uint32_t>(result.landmark.size());
    result.landmark.push_back(next);
    from = geometry::DistancesFrom({{next}}, graph.Links());
    for (std::uint32_t i = 0; i < n; ++i) {
      result.distance(i, k) = from[i];
      if (from[i] < nearest[i]) {
        nearest[i] = from[i];
        result.nearest[i] = k;
      }
    }
    next = geometry::FarthestReached(nearest);
    if (!(nearest[next] > 0.0)) break;
  }
  result.distance.conservativeResize(n, result.landmark.size());
  result.spacing = nearest[next];
  return result;
}

Eigen::MatrixXd BetweenLandmarks(const LandmarkDistances& spread) {
  const std::size_t n = spread.landmark.size();
  Eigen::MatrixXd d(n, n);
  for (std::size_t i = 0; i < n; ++i) d.row(i) = spread.distance.row(spread.landmark[i]);
  return 0.5 * (d + d.transpose());
}

double GuttmanTransform(const MatrixXd& distances, const MatrixX3d& positions, MatrixX3d& next) {
  const Index n = distances.rows();
  next.resize(n, 3);
  double stress = 0.0;
  ArrayXd d;
  for (Index j = 0; j < n; ++j) {
    const auto delta = distances.col(j).array();
    next.row(j) = PullOf(positions, positions.row(j).transpose(), delta, d).transpose();
    stress += (d - delta).square().head(j).sum();
  }
  next /= static_cast<double>(n);
  return stress;
}

MatrixX3d ClassicalScaling(const MatrixXd& distances) {
  const MatrixXd b = DoublyCentered(distances);
  if (b.rows() > kMaxDense) return LeadingCoordinates(b);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(b);
  return Coordinates(solver.eigenvalues(), solver.eigenvectors());
}

Embedding Smacof(const MatrixXd& distances, const SmacofOptions& options) {
  Embedding result;
  result.positions = ClassicalScaling(distances);
  MatrixX3d next, after;
  double before = GuttmanTransform(distances, result.positions, next);
  for (int i = 0; i < options.iterations; ++i) {
    const double stress = GuttmanTransform(distances, next, after);
    if (stress > before) break;  // only by rounding: there is nothing left to gain
    result.positions.swap(next);
    result.stress.push_back(stress);
    if (before - stress <= options.tolerance * before) break;
    next.swap(after);
    before = stress;
  }
  if (result.stress.empty()) result.stress.push_back(before);
  return result;
}

LandmarkPlacement::LandmarkPlacement(const MatrixX3d& landmarks)
    : landmarks_(landmarks), center_(landmarks.colwise().mean().transpose()) {
  const MatrixX3d centered = landmarks_.rowwise() - center_.transpose();
  // x^T X_i = (|X_i|^2 - delta_i^2 + const) / 2 for every i, all relative to the center.
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition(centered);
  solve_ = decomposition.pseudoInverse().transpose();
  squared_norms_ = centered.rowwise().squaredNorm();
}

Eigen::Vector3d LandmarkPlacement::Place(const Eigen::Ref<const Eigen::VectorXd>& distances,
                                         int steps) const {
  Eigen::Vector3d x =
      center_ + 0.5 * (solve_.transpose() *
                       (squared_norms_ - distances.cwiseAbs2()));  // columns of solve_ sum to 0
  ArrayXd d;
  for (int step = 0; step < steps; ++step) {
    x = center_ +
        PullOf(landmarks_, x, distances.array(), d) / static_cast<double>(landmarks_.rows());
  }
  return x;
}

Shape PoseInvariant(const Shape& shape, int landmarks) {
  const LandmarkDistances spread = SpreadLandmarks(GeodesicGraph(shape), landmarks);
  const Embedding embedding = Smacof(BetweenLandmarks(spread), {});
  const LandmarkPlacement placement(embedding.positions);

  Shape result = shape;
  Points& points = result.points;
  const MatrixXd to_landmarks = spread.distance.transpose();
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = placement.Place(to_landmarks.col(i), kPlacementSteps);
  }
  for (std::size_t k = 0; k < spread.landmark.size(); ++k) {
    points[spread.landmark[k]] = embedding.positions.row(k);
  }
  // An embedding may be a mirror image: faces must still be oriented outwards.
  if (geometry::Volume({points, shape.faces}) < 0.0) {
    for (Eigen::Vector3d& p : points) p.z() = -p.z();
  }
  return result;
}

}  // namespace rangegrasp::parts
