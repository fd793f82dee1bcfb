#include "parts/stretched/embedding.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/rng.h"
#include "geometry/mesh.h"
#include "parts/graphs.h"
#include "parts/solids.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Index;
using Eigen::MatrixX3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

MatrixX3d RandomPositions(Index n, base::Rng& rng) {
  MatrixX3d x(n, 3);
  for (Index i = 0; i < n; ++i) {
    for (Index k = 0; k < 3; ++k) x(i, k) = rng.Normal();
  }
  return x;
}

/// Symmetric and positive, but neither Euclidean nor a metric.
MatrixXd RandomDistances(Index n, base::Rng& rng) {
  MatrixXd d = MatrixXd::Zero(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < i; ++j) d(i, j) = d(j, i) = rng.Uniform(0.1, 2.0);
  }
  return d;
}

MatrixXd DistancesOf(const MatrixX3d& x) {
  MatrixXd d(x.rows(), x.rows());
  for (Index i = 0; i < x.rows(); ++i) {
    for (Index j = 0; j < x.rows(); ++j) d(i, j) = (x.row(i) - x.row(j)).norm();
  }
  return d;
}

// Direct implementation of eq. 2.33, 2.35 and 2.36.
double SlowStress(const MatrixXd& delta, const MatrixX3d& x) {
  const MatrixXd d = DistancesOf(x);
  double sum = 0.0;
  for (Index j = 0; j < d.rows(); ++j) {
    for (Index i = 0; i < j; ++i) sum += (d(i, j) - delta(i, j)) * (d(i, j) - delta(i, j));
  }
  return sum;
}

MatrixXd SlowU(Index n) {
  MatrixXd u = MatrixXd::Constant(n, n, -1.0);
  u.diagonal().setConstant(static_cast<double>(n - 1));
  return u;
}

MatrixXd SlowB(const MatrixXd& delta, const MatrixX3d& x) {
  const MatrixXd d = DistancesOf(x);
  MatrixXd b = MatrixXd::Zero(d.rows(), d.rows());
  for (Index i = 0; i < d.rows(); ++i) {
    for (Index j = 0; j < d.rows(); ++j) {
      if (i != j && d(i, j) != 0.0) b(i, j) = -delta(i, j) / d(i, j);
    }
    b(i, i) = -b.row(i).sum();
  }
  return b;
}

class SeededEmbedding : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededEmbedding, ::testing::Range<std::uint64_t>(0, 20));

TEST_P(SeededEmbedding, GuttmanTransformIsThePseudoinverseOfUTimesBTimesX) {
  base::Rng rng(GetParam());
  const Index n = 4 + static_cast<Index>(rng.Index(20));
  const MatrixXd delta = RandomDistances(n, rng);
  MatrixX3d x = RandomPositions(n, rng);
  x.row(1) = x.row(0);  // d_ij = 0
  MatrixX3d next;
  EXPECT_NEAR(GuttmanTransform(delta, x, next), SlowStress(delta, x), 1e-10);
  const MatrixXd pseudoinverse = SlowU(n).completeOrthogonalDecomposition().pseudoInverse();
  EXPECT_LT((next - pseudoinverse * SlowB(delta, x) * x).norm(), 1e-10);
}

TEST_P(SeededEmbedding, GuttmanTransformStepsAgainstTheGradientOfStress) {
  base::Rng rng(GetParam());
  const Index n = 12;
  const MatrixXd delta = RandomDistances(n, rng);
  MatrixX3d x = RandomPositions(n, rng);
  x.rowwise() -= x.colwise().mean().eval();
  MatrixX3d numeric(n, 3);
  constexpr double kStep = 1e-5;
  for (Index i = 0; i < n; ++i) {
    for (Index k = 0; k < 3; ++k) {
      MatrixX3d more = x;
      MatrixX3d less = x;
      more(i, k) += kStep;
      less(i, k) -= kStep;
      numeric(i, k) = (SlowStress(delta, more) - SlowStress(delta, less)) / (2.0 * kStep);
    }
  }
  // Eq. 2.34; central differences have an error of about step^2.
  EXPECT_LT((2.0 * SlowU(n) * x - 2.0 * SlowB(delta, x) * x - numeric).cwiseAbs().maxCoeff(), 1e-6);
  MatrixX3d next;
  GuttmanTransform(delta, x, next);
  EXPECT_LT((x - numeric / (2.0 * static_cast<double>(n)) - next).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(Smacof, StressNeverRisesOverManySeeds) {
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    base::Rng rng(seed);
    const Index n = 4 + static_cast<Index>(rng.Index(30));
    const MatrixXd delta = RandomDistances(n, rng);
    MatrixX3d x = RandomPositions(n, rng);
    double before = SlowStress(delta, x);
    MatrixX3d next;
    for (int i = 0; i < 25; ++i) {
      GuttmanTransform(delta, x, next);
      x.swap(next);
      const double after = SlowStress(delta, x);
      ASSERT_LE(after, before * (1.0 + 1e-12)) << "seed " << seed << " step " << i;
      before = after;
    }
  }
}

TEST_P(SeededEmbedding, StressRecordedIsThatOfTheStepsAndOfTheResult) {
  base::Rng rng(GetParam());
  const MatrixXd delta = RandomDistances(20, rng);
  const Embedding embedding = Smacof(delta, {.iterations = 40, .tolerance = 0.0});
  ASSERT_EQ(embedding.stress.size(), 40u);
  MatrixX3d x = ClassicalScaling(delta);
  MatrixX3d next;
  for (const double stress : embedding.stress) {
    GuttmanTransform(delta, x, next);
    x.swap(next);
    EXPECT_NEAR(stress, SlowStress(delta, x), 1e-9);
  }
  EXPECT_LT((embedding.positions - x).norm(), 1e-9);
}

TEST_P(SeededEmbedding, PointsComeBackFromTheirDistancesUpToARigidMotion) {
  base::Rng rng(GetParam());
  // Below and above the size from which only the leading eigenvectors are computed.
  for (const Index n : {5, 60, 230}) {
    const MatrixXd delta = DistancesOf(RandomPositions(n, rng));
    const Embedding embedding = Smacof(delta, {});
    EXPECT_LT((DistancesOf(embedding.positions) - delta).cwiseAbs().maxCoeff(), 1e-9) << n;
    EXPECT_LT(embedding.stress.back(), 1e-15);
  }
}

TEST_P(SeededEmbedding, LeadingCoordinatesAreThoseOfAllEigenvectors) {
  base::Rng rng(GetParam());
  // A metric similar to a shape's: three long axes and many short ones.
  const Index n = 220;
  MatrixXd x(n, 12);
  for (Index i = 0; i < n; ++i) {
    for (Index k = 0; k < x.cols(); ++k) x(i, k) = rng.Normal() * std::pow(0.6, k);
  }
  MatrixXd delta(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) delta(i, j) = (x.row(i) - x.row(j)).norm();
  }
  const MatrixX3d coordinates = ClassicalScaling(delta);
  x.rowwise() -= x.colwise().mean().eval();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> all(x * x.transpose());
  for (Index k = 0; k < 3; ++k) {
    EXPECT_NEAR(coordinates.col(k).squaredNorm() / all.eigenvalues()[n - 1 - k], 1.0, 1e-9);
    EXPECT_NEAR(std::abs(coordinates.col(k).normalized().dot(all.eigenvectors().col(n - 1 - k))),
                1.0, 1e-9);
  }
}

TEST_P(SeededEmbedding, PlacementFindsAPointFromItsDistances) {
  base::Rng rng(GetParam());
  const MatrixX3d landmarks = RandomPositions(15, rng);
  const LandmarkPlacement placement(landmarks);
  const Vector3d p(rng.Normal(), rng.Normal(), rng.Normal());
  const Eigen::VectorXd delta = (landmarks.rowwise() - p.transpose()).rowwise().norm();
  EXPECT_LT((placement.Place(delta, 0) - p).norm(), 1e-9);
  EXPECT_LT((placement.Place(delta, 10) - p).norm(), 1e-9);
}

TEST_P(SeededEmbedding, PlacementStepsNeverRaiseThePointsStress) {
  base::Rng rng(GetParam());
  const MatrixX3d landmarks = RandomPositions(15, rng);
  const LandmarkPlacement placement(landmarks);
  const Eigen::VectorXd delta = RandomPositions(15, rng).rowwise().norm();
  double before = std::numeric_limits<double>::infinity();
  for (int steps = 0; steps < 30; ++steps) {
    const Vector3d x = placement.Place(delta, steps);
    const double stress =
        ((landmarks.rowwise() - x.transpose()).rowwise().norm() - delta).squaredNorm();
    EXPECT_LE(stress, before * (1.0 + 1e-12));
    before = stress;
  }
}

VertexGraph StretchedRandomGraph(std::uint32_t n, std::size_t links, base::Rng& rng) {
  std::vector<VertexLink> all;
  for (std::uint32_t i = 1; i < n; ++i) {  // a tree first
    const auto j = static_cast<std::uint32_t>(rng.Index(i));
    all.push_back({i, j, rng.Uniform(0.1, 1.0)});
  }
  for (std::size_t k = 0; k < links; ++k) {
    const auto i = static_cast<std::uint32_t>(rng.Index(n));
    const auto j = static_cast<std::uint32_t>(rng.Index(n));
    if (i != j) all.push_back({i, j, rng.Uniform(0.1, 1.0)});
  }
  return GraphOfLinks(n, std::move(all));
}

MatrixXd AllDistances(const VertexGraph& graph) {
  const auto n = static_cast<Index>(graph.begin.size() - 1);
  MatrixXd d = MatrixXd::Constant(n, n, std::numeric_limits<double>::infinity());
  for (Index i = 0; i < n; ++i) {
    d(i, i) = 0.0;
    for (auto k = graph.begin[static_cast<std::size_t>(i)];
         k < graph.begin[static_cast<std::size_t>(i) + 1]; ++k) {
      d(i, graph.neighbor[k]) = graph.length[k];
    }
  }
  samples::Shorten(d);
  return d;
}

TEST_P(SeededEmbedding, EachNextPointIsTheFarthestFromThoseBefore) {
  base::Rng rng(GetParam());
  const VertexGraph graph = StretchedRandomGraph(40, 60, rng);
  const MatrixXd all = AllDistances(graph);
  const LandmarkDistances spread = SpreadLandmarks(graph, 12);
  const std::vector<std::uint32_t>& points = spread.landmark;
  ASSERT_EQ(points.size(), 12u);
  EXPECT_NEAR(all(0, points[0]), all.row(0).maxCoeff(), 1e-12);
  Eigen::RowVectorXd nearest = all.row(points[0]);
  for (std::size_t k = 1; k < points.size(); ++k) {
    EXPECT_NEAR(nearest[points[k]], nearest.maxCoeff(), 1e-12);
    nearest = nearest.cwiseMin(all.row(points[k]));
  }
  EXPECT_NEAR(spread.spacing, nearest.maxCoeff(), 1e-12);
  for (std::uint32_t v = 0; v < 40; ++v) {
    EXPECT_NEAR(spread.distance(v, spread.nearest[v]), nearest[v], 1e-12);
    EXPECT_NEAR(spread.distance(v, 5), all(v, points[5]), 1e-12);
  }
  EXPECT_EQ(SpreadLandmarks(graph, 1000).landmark.size(), 40u);
}

TEST(Geodesic, AnUnfoldedDiagonalIsStraight) {
  const Vector3d a(0, 0, 0), b(1, 0, 0), c(0.5, 1, 0);
  for (const double fold : {0.0, 0.7, 2.0}) {  // the other triangle is rotated about a-b
    const Vector3d d(0.5, -2.0 * std::cos(fold), 2.0 * std::sin(fold));
    ASSERT_TRUE(UnfoldedDistance(a, b, c, d));
    EXPECT_NEAR(*UnfoldedDistance(a, b, c, d), 3.0, 1e-12);
  }
  EXPECT_FALSE(UnfoldedDistance(a, b, Vector3d(-1, 1, 0), Vector3d(-1, -1, 0)));
  EXPECT_FALSE(UnfoldedDistance(a, a, c, Vector3d(0.5, -1, 0)));
}

TEST(Geodesic, DistancesOnABallAreNearlyThoseAlongGreatCircles) {
  const Shape ball = samples::Ball(24, [](const Vector3d&) { return 1.0; });
  const std::vector<std::uint32_t> sources = {0, 100, 500};
  const VertexGraph graph = GeodesicGraph(ball);
  double sum = 0.0;
  for (const std::uint32_t source : sources) {
    const std::vector<double> d = geometry::DistancesFrom({{source}}, graph.Links());
    for (std::uint32_t v = 0; v < ball.points.size(); ++v) {
      if (v == source) continue;
      const double arc = std::acos(std::clamp(ball.points[source].dot(ball.points[v]), -1.0, 1.0));
      const double ratio = d[v] / arc;
      // Chords are shorter than arcs by h^2 / 24 < 0.001. The neighbors of a vertex, with those
      // across edges, are at most 45 degrees apart in this grid, and 62 at the cube's corners: 1 /
      // cos(31 degrees).
      ASSERT_GT(ratio, 0.999);
      ASSERT_LT(ratio, 1.167);
      sum += ratio;
    }
  }
  // Along edges alone the mean is above 1.06.
  EXPECT_LT(sum / static_cast<double>(3 * ball.points.size()), 1.04);
}

TEST(Geodesic, PiecesThatAreNotJoinedGetTheirShortestLink) {
  const Shape two = samples::Twice(samples::Ball(4, [](const Vector3d&) { return 1.0; }));
  const auto n = static_cast<std::uint32_t>(two.points.size() / 2);
  const std::vector<double> d = geometry::DistancesFrom({{0U}}, GeodesicGraph(two).Links());
  for (const double x : d) EXPECT_TRUE(std::isfinite(x));
  double gap = std::numeric_limits<double>::infinity();
  std::uint32_t end = 0;  // end of the link on the first ball
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = n; j < 2 * n; ++j) {
      if ((two.points[i] - two.points[j]).norm() >= gap) continue;
      gap = (two.points[i] - two.points[j]).norm();
      end = i;
    }
  }
  EXPECT_NEAR(*std::min_element(d.begin() + n, d.end()), d[end] + gap, 1e-12);
}

/// Center of a ring of a tube made by samples::Tube.
Vector3d RingCenter(const Shape& tube, std::size_t ring, std::size_t around) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < around; ++k) sum += tube.points[ring * around + k];
  return sum / static_cast<double>(around);
}

/// Half a circle of radius 1: its ends are 2 apart; along a tube they are pi apart.
Vector3d HalfCircle(double t) {
  const double angle = std::numbers::pi * t;
  return {std::cos(angle), std::sin(angle), 0.0};
}

TEST(PoseInvariant, ABentTubeBecomesStraight) {
  constexpr std::size_t kLimbRings = 81;
  constexpr std::size_t kAround = 16;
  const Shape tube = samples::Tube(kLimbRings, kAround, HalfCircle, [](double) { return 0.01; });
  const Shape straight = PoseInvariant(tube);
  EXPECT_EQ(straight.faces, tube.faces);
  const Vector3d first = RingCenter(straight, 0, kAround);
  const Vector3d last = RingCenter(straight, kLimbRings - 1, kAround);
  EXPECT_NEAR((last - first).norm(), std::numbers::pi, 0.1 * std::numbers::pi);
  const Vector3d axis = (last - first).normalized();
  for (std::size_t ring = 0; ring < kLimbRings; ++ring) {
    const Vector3d p = RingCenter(straight, ring, kAround) - first;
    // Before, the middle is 1 off the line between the ends. A small bend remains: the inner side
    // is shorter than the outer one by pi * 0.02. A thick tube stays partly bent.
    EXPECT_LT((p - axis.dot(p) * axis).norm(), 0.1) << ring;
  }
  EXPECT_GT(geometry::Volume({straight.points, straight.faces}), 0.0);
}

TEST(PoseInvariant, KnowsNoTurnShiftAndScale) {
  const auto bump = [](const Vector3d& n) { return 1.0 + 0.5 * n.x() * n.x() + 0.2 * n.y(); };
  const Shape shape = samples::Ball(10, bump);
  Shape moved = shape;
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  for (Vector3d& p : moved.points) p = 40.0 * (turn * p) + Vector3d(3, -2, 7);
  const Shape a = PoseInvariant(shape, 100);
  const Shape b = PoseInvariant(moved, 100);
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    for (const std::size_t j : {std::size_t{0}, std::size_t{33}}) {
      EXPECT_NEAR((b.points[i] - b.points[j]).norm(), 40.0 * (a.points[i] - a.points[j]).norm(),
                  1e-4);
    }
  }
  EXPECT_GT(geometry::Volume({a.points, a.faces}), 0.0);
}

TEST(PoseInvariant, ACloudIsStraightenedAsItsMeshIs) {
  Shape cloud = samples::Tube(81, 16, HalfCircle, [](double) { return 0.08; });
  cloud.faces.clear();
  const Shape straight = PoseInvariant(cloud);
  EXPECT_TRUE(straight.faces.empty());
  EXPECT_NEAR((RingCenter(straight, 80, 16) - RingCenter(straight, 0, 16)).norm(), std::numbers::pi,
              0.1 * std::numbers::pi);
}

}  // namespace
}  // namespace rangegrasp::parts
