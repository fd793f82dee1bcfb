#include "pcl_bridge/cloud.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "geometry/plane.h"
#include "noisy_surfaces.h"
#include "pcl_bridge/pcl_segmentation.h"

namespace rangegrasp::pcl_bridge {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A square with a hole (NaN) at every third position.
geometry::Points SquareWithHoles(base::Rng& rng) {
  geometry::Points points;
  for (const auto& p :
       samples::OnSquare({0.3, 0.1, 0.8}, Eigen::Vector3d::UnitZ(), 0.05, 0.0, 2000, rng)) {
    if (points.size() % 3 == 0) points.emplace_back(0.1, kNaN, 0.2);
    points.push_back(p);
  }
  return points;
}

TEST(Cloud, PositionsCountThePointsGivenThoughSomeAreNotFinite) {
  base::Rng rng(1);
  const geometry::Points points = SquareWithHoles(rng);
  const Cloud cloud(points);
  EXPECT_EQ(cloud.size(), points.size());
  geometry::Indices finite;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].allFinite()) finite.push_back(static_cast<std::uint32_t>(i));
  }
  const auto plane = FitPlane(cloud);
  ASSERT_TRUE(plane);
  EXPECT_EQ(plane->inliers, finite);
  const auto clusters = EuclideanClusters(cloud, {.tolerance_m = 0.05});
  ASSERT_EQ(clusters.size(), 1u);
  EXPECT_EQ(clusters.front(), finite);
  const geometry::Points normals = EstimateNormals(cloud, {.radius_m = 0.02});
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(normals[i].allFinite(), points[i].allFinite()) << i;
  }
  const LocalConvexity convexity = SegmentByLocalConvexity(cloud);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) {
      EXPECT_EQ(convexity.segment[i], -1) << i;
    }
  }
}

// Selected points get new indices in the given order; a hole remains a hole.
TEST(Cloud, SelectCountsFromZeroInTheOrderAskedFor) {
  const geometry::Points points = {{0, 0, 1}, {1, 0, 1}, {kNaN, 0, 1}, {0, 1, 1}, {0, 0, 9}};
  const Cloud cloud(points, {0.1, 0.2, 0.3});
  const geometry::Indices indices = {3, 2, 1, 0};
  const Cloud selected = cloud.Select(indices);
  EXPECT_EQ(selected.size(), 4u);
  const auto plane = FitPlane(selected);
  ASSERT_TRUE(plane);
  EXPECT_EQ(plane->inliers, (geometry::Indices{0, 2, 3}));
  EXPECT_NEAR(plane->plane.Distance({0.4, 0.7, 1.0}), 0.0, 1e-6);
  EXPECT_THROW(cloud.Select(geometry::Indices{5}), std::invalid_argument);
}

// At 1000 m single precision resolves 0.06 mm; relative to an origin nearby it resolves 0.1 um.
TEST(Cloud, KeepsItsPrecisionFarFromTheFramesOrigin) {
  base::Rng rng(2);
  const Eigen::Vector3d far(1000.0, -2000.0, 500.0);
  const Eigen::Vector3d normal = Eigen::Vector3d(1.0, 2.0, -3.0).normalized();
  const auto points = samples::OnSquare(far, normal, 0.1, 0.0, 500, rng);
  const auto fit = FitPlane(Cloud(points, far + 0.5 * normal));
  ASSERT_TRUE(fit);
  for (const auto& p : points) EXPECT_NEAR(fit->plane.Distance(p), 0.0, 2e-6);
  EXPECT_GT(fit->plane.Distance(far + 0.5 * normal), 0.0);
}

TEST(Cloud, NothingIsFoundInNothing) {
  for (const geometry::Points& points :
       {geometry::Points{}, geometry::Points(3, Eigen::Vector3d(0, 0, kNaN))}) {
    const Cloud cloud(points);
    const geometry::Points normals = EstimateNormals(cloud);
    EXPECT_FALSE(FitPlane(cloud));
    EXPECT_FALSE(FitCylinder(cloud, normals));
    EXPECT_TRUE(StatisticalFilter(cloud).empty());
    EXPECT_TRUE(EuclideanClusters(cloud).empty());
    EXPECT_EQ(SegmentByLocalConvexity(cloud).segments, 0);
    EXPECT_EQ(SegmentByLocalConvexity(cloud).segment.size(), points.size());
  }
}

// The library prints messages about failed fits and missing neighbors.
TEST(Cloud, SilencesTheLibrary) {
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  const Cloud one(geometry::Points(5, Eigen::Vector3d::UnitZ()));
  const geometry::Points normals = EstimateNormals(one);
  EXPECT_FALSE(FitPlane(one));
  EXPECT_FALSE(FitCylinder(one, normals));
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST(Cloud, WhatDoesNotFitIsRefused) {
  const Cloud cloud(geometry::Points{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}});
  EXPECT_THROW(Cloud({}, Eigen::Vector3d(0, 0, kNaN)), std::invalid_argument);
  EXPECT_THROW(FitCylinder(cloud, {}), std::invalid_argument);
  EXPECT_THROW(SegmentByLocalConvexity(Cloud(geometry::Points{{0, 0, -1}}), {.camera_depth = true}),
               std::invalid_argument);
}

class SeededNormals : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededNormals, ::testing::Range<std::uint64_t>(0, 20));

TEST_P(SeededNormals, AreThoseOfGeometryButForRounding) {
  base::Rng rng(GetParam());
  const Eigen::Vector3d center = samples::RandomPoint(0.3, rng);
  const Eigen::Vector3d normal = samples::RandomDirection(rng);
  const Eigen::Vector3d sensor = center + 0.7 * normal;
  const auto points = samples::OnSquare(center, normal, 0.05, 0.0005, 2000, rng);
  const auto ours = geometry::EstimateNormals(points, geometry::KdTree(points), 0.01, sensor);
  const geometry::Points found = EstimateNormals(Cloud(points, sensor), {.radius_m = 0.01});
  // The library computes the eigenvector in closed form and single precision, mostly to 1e-4 rad.
  // For a few in ten thousand neighborhoods of poor shape, rounding limits it to 0.01 rad.
  std::size_t far = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double off = (ours[i] - found[i]).norm();
    EXPECT_LT(off, 0.01) << i;
    far += off > 1e-4 ? 1 : 0;
    EXPECT_GT(found[i].dot(sensor - points[i]), 0.0) << i;
  }
  EXPECT_LT(far, points.size() / 100);
}

TEST_P(SeededNormals, OnATubeArePerpendicularToItsAxisAndTurnTowardsTheSensor) {
  base::Rng rng(GetParam());
  const samples::Tube tube{{0.1, 0.2, 0.5}, samples::RandomDirection(rng), 0.04, 0.1};
  const auto points = samples::OnTube(tube, 0.0, 8000, rng);
  const geometry::Points found = EstimateNormals(Cloud(points, tube.center), {.radius_m = 0.006});
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d along = (points[i] - tube.center).dot(tube.axis) * tube.axis;
    if (along.norm() > tube.half_length_m - 0.006) continue;  // no surface on one side
    const Eigen::Vector3d inwards = (tube.center + along - points[i]).normalized();
    // Over 6 mm the tube bends by 6 / 40 rad; an uneven point distribution tilts the normal by a
    // part of that.
    EXPECT_GT(found[i].dot(inwards), std::cos(0.15)) << i;
  }
}

TEST(Normals, ThreePointsMakeOneAndTwoDoNot) {
  const geometry::Points points = {
      {0, 0, 1}, {0.001, 0, 1}, {0, 0.001, 1}, {1, 0, 1}, {1.001, 0, 1}};
  const geometry::Points normals = EstimateNormals(Cloud(points));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT((normals[i] + Eigen::Vector3d::UnitZ()).norm(), 1e-3);
  }
  for (std::size_t i = 3; i < 5; ++i) EXPECT_FALSE(normals[i].allFinite());
}

class SeededOutliers : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededOutliers, ::testing::Range<std::uint64_t>(0, 20));

geometry::Points MakePoints(base::Rng& rng) {
  geometry::Points points =
      samples::OnSquare({0, 0, 0.5}, Eigen::Vector3d::UnitZ(), 0.05, 0.0005, 500, rng);
  for (int i = 0; i < 50; ++i)
    points.push_back(Eigen::Vector3d(0, 0, 0.5) + samples::RandomPoint(0.1, rng));
  return points;
}

/// Ascending distances from points[i] to all others.
std::vector<double> Distances(const geometry::Points& points, std::size_t i) {
  std::vector<double> distances;
  for (std::size_t j = 0; j < points.size(); ++j) {
    if (j != i) distances.push_back((points[j] - points[i]).norm());
  }
  std::ranges::sort(distances);
  return distances;
}

/// Checks each point against the bound, except points within rounding of it.
void ExpectKept(const geometry::Indices& kept, const std::vector<double>& value, double bound) {
  EXPECT_TRUE(std::ranges::is_sorted(kept));
  for (std::uint32_t i = 0; i < value.size(); ++i) {
    if (std::abs(value[i] - bound) < 1e-6) continue;
    EXPECT_EQ(std::ranges::binary_search(kept, i), value[i] <= bound) << i;
  }
}

TEST_P(SeededOutliers, StatisticalFilterIsTheBruteForceOne) {
  base::Rng rng(GetParam());
  const geometry::Points points = MakePoints(rng);
  const StatisticalFilterOptions options{.neighbors = 10, .max_deviations = 1.5};
  std::vector<double> mean_distance;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto distances = Distances(points, i);
    mean_distance.push_back(
        std::accumulate(distances.begin(), distances.begin() + options.neighbors, 0.0) /
        options.neighbors);
  }
  const auto n = static_cast<double>(points.size());
  const double mean = std::accumulate(mean_distance.begin(), mean_distance.end(), 0.0) / n;
  double squares = 0.0;
  for (const double d : mean_distance) squares += (d - mean) * (d - mean);
  ExpectKept(StatisticalFilter(Cloud(points), options), mean_distance,
             mean + options.max_deviations * std::sqrt(squares / (n - 1.0)));
}

TEST(Outliers, CloudsOfFewPointsPass) {
  for (std::size_t n = 1; n < 5; ++n) {
    base::Rng rng(n);
    const Cloud cloud(geometry::samples::RandomPoints(n, 0.1, rng));
    EXPECT_EQ(StatisticalFilter(cloud, {.neighbors = 50, .max_deviations = 10.0}).size(), n);
  }
}

}  // namespace
}  // namespace rangegrasp::pcl_bridge
