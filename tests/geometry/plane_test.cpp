#include "geometry/plane.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>

#include "geometry/random_points.h"
#include "geometry/synthetic.h"

namespace rangegrasp::geometry {
namespace {

using samples::RandomDirection;
using samples::RandomPoint;

class SeededPlane : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededPlane, ::testing::Range<std::uint64_t>(0, 40));

/// n random points of a cube of side 2 half, projected onto the plane, with noise along its normal.
Points OnPlane(const Plane& plane, std::size_t n, double half, double sigma, base::Rng& rng) {
  Points points;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d p = plane.Project(RandomPoint(half, rng));
    points.push_back(p + sigma * rng.Normal() * plane.normal);
  }
  return points;
}

Plane RandomPlane(base::Rng& rng) {
  Plane plane;
  plane.normal = RandomDirection(rng);
  plane.offset_m = rng.Uniform(-0.1, 0.1);
  return plane;
}

TEST_P(SeededPlane, PlaneThroughHoldsItsPointsAndHasAUnitNormal) {
  base::Rng rng(GetParam());
  const Eigen::Vector3d a = RandomPoint(1.0, rng);
  const Eigen::Vector3d b = RandomPoint(1.0, rng);
  const Eigen::Vector3d c = RandomPoint(1.0, rng);
  const auto plane = PlaneThrough(a, b, c);
  ASSERT_TRUE(plane);
  EXPECT_NEAR(plane->normal.norm(), 1.0, 1e-12);
  for (const Eigen::Vector3d& p : {a, b, c}) EXPECT_NEAR(plane->Distance(p), 0.0, 1e-12);
  EXPECT_GT(plane->normal.dot((b - a).cross(c - a)), 0.0);
  EXPECT_FALSE(PlaneThrough(a, b, a + 2.5 * (b - a)));
  EXPECT_FALSE(PlaneThrough(a, a, b));
}

TEST_P(SeededPlane, DistanceChangesSignAcrossThePlaneAndProjectLandsOnIt) {
  base::Rng rng(GetParam());
  const Plane plane = RandomPlane(rng);
  const Eigen::Vector3d on = plane.Project(RandomPoint(1.0, rng));
  EXPECT_NEAR(plane.Distance(on), 0.0, 1e-12);
  EXPECT_NEAR(plane.Distance(on + 0.3 * plane.normal), 0.3, 1e-12);
  EXPECT_NEAR(plane.Distance(on - 0.3 * plane.normal), -0.3, 1e-12);
}

TEST_P(SeededPlane, FitPlaneFindsTheTruthWithinItsStandardError) {
  base::Rng rng(GetParam());
  const Plane truth = RandomPlane(rng);
  const double sigma = 0.001;
  const std::size_t n = 500;
  const auto plane = FitPlane(OnPlane(truth, n, 0.2, sigma, rng));
  ASSERT_TRUE(plane);
  // Six standard errors. The slope's standard error is sigma / (spread sqrt(n)); the spread of a
  // projected cube with half side 0.2 is at least 0.2 / sqrt(3) = 0.115.
  const double error = 6.0 * sigma / (0.115 * std::sqrt(static_cast<double>(n)));
  EXPECT_GT(std::abs(plane->normal.dot(truth.normal)), std::cos(error));
}

TEST(Plane, FitPlaneRefusesWhatLiesOnALine) {
  EXPECT_FALSE(FitPlane(Points{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}}));
  EXPECT_FALSE(FitPlane(Points{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, {2.0, 2.0, 2.0}}));
  EXPECT_FALSE(FitPlane(Points(5, Eigen::Vector3d(1.0, 2.0, 3.0))));
}

TEST_P(SeededPlane, RansacFindsAPlaneThatHoldsHalfOfThePoints) {
  base::Rng rng(GetParam());
  const Plane truth = RandomPlane(rng);
  Points points = OnPlane(truth, 400, 0.2, 0.0005, rng);
  for (int i = 0; i < 400; ++i) points.push_back(RandomPoint(0.2, rng));
  // 100 draws miss with probability (1 - 0.5^3)^100 = 2e-6.
  const auto fit = FitPlaneRansac(points, {}, rng);
  ASSERT_TRUE(fit);
  EXPECT_GT(std::abs(fit->plane.normal.dot(truth.normal)), std::cos(0.01));
  EXPECT_GE(fit->inliers.size(), 395u);  // 4 sigma of noise; tilt loses a few
  for (std::size_t i = 1; i < fit->inliers.size(); ++i) {
    EXPECT_LT(fit->inliers[i - 1], fit->inliers[i]);
  }
  std::size_t within = 0;
  for (const Eigen::Vector3d& p : points) {
    within += std::abs(fit->plane.Distance(p)) <= 0.002 ? 1 : 0;
  }
  EXPECT_EQ(within, fit->inliers.size());
}

// The fit is as accurate as a fit to all points of the plane, not only to the three drawn points.
// The bound is six standard errors of 400 points (see FitPlane's test) plus the tilt from four
// stray points within 2 mm.
TEST_P(SeededPlane, RansacRefitsToItsInliers) {
  base::Rng rng(GetParam());
  const Plane truth = RandomPlane(rng);
  Points points = OnPlane(truth, 400, 0.2, 0.0005, rng);
  for (int i = 0; i < 100; ++i) points.push_back(RandomPoint(0.2, rng));
  const auto fit = FitPlaneRansac(points, {}, rng);
  ASSERT_TRUE(fit);
  const double error = 6.0 * 0.0005 / (0.115 * 20.0) + 4.0 * 0.002 / 400.0 / 0.115;
  EXPECT_GT(std::abs(fit->plane.normal.dot(truth.normal)), std::cos(error));
}

// Inliers are counted over all points, wherever in the order the plane's points are.
TEST_P(SeededPlane, RansacCountsToTheEnd) {
  base::Rng rng(GetParam());
  const Plane truth = RandomPlane(rng);
  Points points;
  for (int i = 0; i < 2500; ++i) points.push_back(RandomPoint(0.2, rng));
  for (const auto& p : OnPlane(truth, 2500, 0.2, 0.0005, rng)) points.push_back(p);
  const auto fit = FitPlaneRansac(points, {}, rng);  // misses in (1 - 0.5^3)^100 = 2e-6
  ASSERT_TRUE(fit);
  EXPECT_GE(fit->inliers.size(), 2480u);
}

TEST_P(SeededPlane, RansacDependsOnItsArgumentsAndTheStreamAlone) {
  base::Rng draw(GetParam());
  const Points points = samples::RandomPoints(200, 0.2, draw);
  base::Rng a(GetParam()), b(GetParam());
  const auto first = FitPlaneRansac(points, {}, a);
  const auto again = FitPlaneRansac(points, {}, b);
  ASSERT_TRUE(first && again);
  EXPECT_EQ(first->plane.normal, again->plane.normal);
  EXPECT_EQ(first->plane.offset_m, again->plane.offset_m);
  EXPECT_EQ(first->inliers, again->inliers);
  EXPECT_EQ(a.Uniform(), b.Uniform());
}

TEST(Plane, IsFlatToANanometreAMetre) {
  base::Rng rng(2);
  for (const auto& [thickness, flat] : {std::pair(0.0, true), {1e-11, true}, {1e-6, false}}) {
    Points points = samples::RandomPoints(50, 1.0, rng);
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i].z() = i % 2 == 0 ? thickness : -thickness;
    }
    EXPECT_EQ(IsFlat(points), flat) << thickness;
  }
  EXPECT_TRUE(IsFlat(Points(5, Eigen::Vector3d(1.0, 2.0, 3.0))));
}

TEST(Plane, RansacNeedsThreePointsThatAreNotOnALine) {
  base::Rng rng(1);
  EXPECT_FALSE(FitPlaneRansac(Points{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}, {}, rng));
  EXPECT_FALSE(FitPlaneRansac(Points{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {3.0, 0.0, 0.0}}, {}, rng));
}

TEST(Plane, RansacFindsTheOnlyPlaneOfThreePointsInOneDraw) {
  // Three draws without repetition must give all three points; a repeated index gives no plane.
  const Points points = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    base::Rng rng(seed);
    const auto fit = FitPlaneRansac(points, {1, 0.002}, rng);
    ASSERT_TRUE(fit);
    EXPECT_EQ(fit->inliers.size(), 3u);
  }
}

TEST(Normals, OfAPlaneAreItsNormalTurnedToTheOrigin) {
  base::Rng rng(1);
  const Eigen::Vector3d normal = samples::RandomDirection(rng);
  Points points = samples::RandomPoints(800, 0.03, rng);
  for (Eigen::Vector3d& p : points) p -= p.dot(normal) * normal;
  const KdTree tree(points);
  for (const double side : {1.0, -1.0}) {
    for (const auto& n : EstimateNormals(points, tree, 0.005, Points{side * normal}, {})) {
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
  const Points normals = EstimateNormals(points, tree, 0.005, Points{{0.1, 0.2, 0.3}}, {});
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Normals point to the centre, since the origin is there. About 75 samples per neighborhood are
    // evenly spread to a fraction of the sample width, 1 mm of 5: the tilt is well below 0.02 rad.
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
  const Points normals = EstimateNormals(points, tree, 0.01, Points{{1.0, 1.0, 1.0}}, {});
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
  // The radius grows where a neighborhood lies on a line; the kept lists are for the first radius.
  EstimateNormals(points, tree, 0.004, {&eye, 1}, {}, 0.02, &kept);
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
  for (const auto& n :
       EstimateNormals(points, KdTree(points), 0.005, Points{{0.2, 0.2, 3.0}}, {})) {
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
  const auto normals = EstimateNormals(one, KdTree(one), 0.005, Points{origin}, {});
  EXPECT_LT((normals[0] - Eigen::Vector3d(0.6, 0.8, 0.0)).norm(), 1e-12);
}

// A roof of two triangles. A face's own corners have its normal, shared corners have the mean
// weighted by area, and the normal of a point without a triangle points to its viewpoint.
TEST(FaceNormals, AreTheAreaWeightedMeansOfTheFaces) {
  const Points points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -2, 2}, {5, 5, 0}};
  const std::vector<std::array<std::uint32_t, 3>> triangles{{0, 2, 1}, {0, 1, 3}};
  const Points places{{0.0, 0.0, 10.0}};
  const auto normals = FaceNormals(points, triangles, places, Indices(points.size(), 0));
  // The areas are 1/2 and sqrt(2); twice that is along z and along (0, 1, 1) / sqrt(2).
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
    for (const auto& n :
         EstimateNormals(points, KdTree(points), 0.005, Points{{0.0, 0.0, 0.0}}, {})) {
      EXPECT_NEAR(n.norm(), 1.0, 1e-12);
    }
  }
  EXPECT_TRUE(
      EstimateNormals(Points{}, KdTree(Points{}), 0.005, Points{{0.0, 0.0, 0.0}}, {}).empty());
}

}  // namespace
}  // namespace rangegrasp::geometry
