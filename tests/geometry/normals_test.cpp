#include "geometry/normals.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "geometry/random_points.h"
#include "geometry/synthetic.h"

namespace rangegrasp::geometry {
namespace {

TEST(Normals, OfAPlaneAreItsNormalTurnedToTheOrigin) {
  base::Rng rng(1);
  const Eigen::Vector3d normal = samples::RandomDirection(rng);
  Points points = samples::RandomPoints(800, 0.03, rng);
  for (Eigen::Vector3d& p : points) p -= p.dot(normal) * normal;
  const KdTree tree(points);
  for (const double side : {1.0, -1.0}) {
    for (const auto& n : EstimateNormals(points, tree, 0.005, side * normal)) {
      EXPECT_NEAR(n.dot(side * normal), 1.0, 1e-9);
    }
  }
}

TEST(Normals, OfASphereAreRadial) {
  const double radius = 0.05;
  Points points;
  synthetic::Sample(synthetic::Sphere{{0.1, 0.2, 0.3}, radius}, 0.001,
                    [&](const synthetic::Surfel& s) { points.push_back(s.point); });
  const KdTree tree(points);
  const Points normals = EstimateNormals(points, tree, 0.005, {0.1, 0.2, 0.3});
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Towards the centre, since the origin is there. About 75 samples in the neighbourhood are
    // spread evenly to a fraction of a sample's width, 1 mm of 5: well below 0.02 rad of tilt.
    const Eigen::Vector3d inward = (Eigen::Vector3d(0.1, 0.2, 0.3) - points[i]).normalized();
    EXPECT_GT(normals[i].dot(inward), std::cos(0.02));
    EXPECT_NEAR(normals[i].norm(), 1.0, 1e-12);
  }
}

TEST(Normals, AreTheSmallestEigenvectorsOfTheCovariance) {
  // A direct transcription of eq. 4.10-4.12 with another solver.
  base::Rng rng(5);
  const Points points = samples::RandomPoints(300, 0.02, rng);
  const KdTree tree(points);
  const Points normals = EstimateNormals(points, tree, 0.01, {1.0, 1.0, 1.0});
  for (std::size_t i = 0; i < points.size(); ++i) {
    Points near;
    for (const Eigen::Vector3d& p : points) {
      if ((p - points[i]).norm() < 0.01) near.push_back(p);
    }
    if (near.size() < 4) continue;
    const Eigen::Vector3d mean = Centroid(near);
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const auto& p : near) covariance += (p - mean) * (p - mean).transpose();
    covariance /= static_cast<double>(near.size() - 1);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
    if (solver.eigenvalues()[1] < 1.05 * solver.eigenvalues()[0]) continue;  // ill-defined
    EXPECT_NEAR(std::abs(normals[i].dot(solver.eigenvectors().col(0))), 1.0, 1e-8);
  }
}

TEST(Normals, KeepTheNeighborsThatTheySearchedFor) {
  base::Rng rng(6);
  const Points points = samples::RandomPoints(300, 0.02, rng);
  const KdTree tree(points);
  const Eigen::Vector3d eye(1.0, 1.0, 1.0);
  NeighborLists kept;
  // Widened where a neighborhood lies on a line: what is kept is of the first radius.
  EstimateNormals(points, tree, 0.004, {&eye, 1}, Indices(points.size(), 0), 0.02, &kept);
  EXPECT_EQ(kept.radius_m, 0.004);
  std::vector<KdTree::Neighbor> neighbors;
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_TRUE(kept.Has(i));
    tree.Within(points[i], 0.004, neighbors);
    ASSERT_EQ(kept.Of(i).size(), neighbors.size());
    for (std::size_t k = 0; k < neighbors.size(); ++k) {
      EXPECT_EQ(kept.Of(i)[k], neighbors[k].index);
    }
  }
  EXPECT_FALSE(kept.Has(points.size()));
}

TEST(Normals, ALonePointTakesThePlaneOfItsNearestThree) {
  const Points points = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
  for (const auto& n : EstimateNormals(points, KdTree(points), 0.005, {0.2, 0.2, 3.0})) {
    EXPECT_NEAR(n.z(), 1.0, 1e-12);
  }
}

TEST(Normals, TurnToThePlaceThatSawThePoint) {
  base::Rng rng(6);
  Points points = samples::RandomPoints(400, 0.03, rng);
  Indices place_of;
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].z() = 0.0;
    place_of.push_back(i % 3 == 0 ? 1 : 0);
  }
  const Points places{{0.0, 0.0, 1.0}, {0.0, 0.0, -1.0}};
  const Points normals = EstimateNormals(points, KdTree(points), 0.01, places, place_of);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(normals[i].z(), place_of[i] == 0 ? 1.0 : -1.0, 1e-9);
  }
}

TEST(Normals, OfALonePointPointsToTheOrigin) {
  const Points one{{0.1, 0.2, 0.3}};
  const Eigen::Vector3d origin(0.4, 0.6, 0.3);
  const auto normals = EstimateNormals(one, KdTree(one), 0.005, origin);
  EXPECT_LT((normals[0] - Eigen::Vector3d(0.6, 0.8, 0.0)).norm(), 1e-12);
}

// A roof of two triangles: each face's normal at its own corners, at the shared ones the mean
// weighted by area, and a point of no triangle faces where it was seen from.
TEST(FaceNormals, AreTheAreaWeightedMeansOfTheFaces) {
  const Points points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -2, 2}, {5, 5, 0}};
  const std::vector<std::array<std::uint32_t, 3>> triangles{{0, 2, 1}, {0, 1, 3}};
  const Points places{{0.0, 0.0, 10.0}};
  const auto normals = FaceNormals(points, triangles, places, Indices(points.size(), 0));
  // Areas 1/2 and sqrt(2): twice them along z and along (0, 1, 1) / sqrt(2).
  const Eigen::Vector3d flat(0, 0, 1), slope(0, 2, 2);
  EXPECT_LT((normals[2] - flat).norm(), 1e-12);
  EXPECT_LT((normals[3] - slope.normalized()).norm(), 1e-12);
  EXPECT_LT((normals[0] - (flat + slope).normalized()).norm(), 1e-12);
  EXPECT_LT((normals[1] - (flat + slope).normalized()).norm(), 1e-12);
  EXPECT_LT((normals[4] - Eigen::Vector3d(-5, -5, 10).normalized()).norm(), 1e-12);
}

TEST(Normals, AreUnitLengthWhereNothingDefinesThem) {
  for (const Points& points :
       {Points{{0.0, 0.0, 0.0}}, Points{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}},
        Points{{0.0, 0.0, 0.0}, {0.001, 0.0, 0.0}, {0.002, 0.0, 0.0}}}) {
    for (const auto& n : EstimateNormals(points, KdTree(points), 0.005, {0.0, 0.0, 0.0})) {
      EXPECT_NEAR(n.norm(), 1.0, 1e-12);
    }
  }
  EXPECT_TRUE(EstimateNormals(Points{}, KdTree(Points{}), 0.005, {0.0, 0.0, 0.0}).empty());
}

}  // namespace
}  // namespace rangegrasp::geometry
