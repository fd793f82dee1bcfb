#include "pcl_bridge/cloud.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "noisy_surfaces.h"
#include "pcl_bridge/clusters.h"
#include "pcl_bridge/local_convexity.h"
#include "pcl_bridge/outliers.h"
#include "pcl_bridge/ransac.h"
#include "pcl_bridge/registration.h"

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
  const Normals normals = EstimateNormals(cloud, {.radius_m = 0.02});
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(normals.directions[i].allFinite(), points[i].allFinite()) << i;
  }
  const LocalConvexity convexity = SegmentByLocalConvexity(cloud);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) {
      EXPECT_EQ(convexity.segment[i], -1) << i;
    }
  }
}

// What was selected counts anew; a hole stays a hole, and an order is kept.
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
    const Normals normals = EstimateNormals(cloud);
    EXPECT_FALSE(FitPlane(cloud));
    EXPECT_FALSE(FitCylinder(cloud, normals));
    EXPECT_TRUE(StatisticalFilter(cloud).empty());
    EXPECT_TRUE(RadiusFilter(cloud).empty());
    EXPECT_TRUE(EuclideanClusters(cloud).empty());
    EXPECT_TRUE(GrowRegions(cloud, normals).empty());
    EXPECT_EQ(SegmentByLocalConvexity(cloud).segments, 0);
    EXPECT_EQ(SegmentByLocalConvexity(cloud).segment.size(), points.size());
    EXPECT_THROW(RegisterPointToPlane(cloud, cloud, Eigen::Isometry3d::Identity()),
                 std::invalid_argument);
    EXPECT_THROW(RegisterGeneralized(cloud, cloud, Eigen::Isometry3d::Identity()),
                 std::invalid_argument);
  }
}

// The library writes about failed fits and missing neighbors.
TEST(Cloud, SilencesTheLibrary) {
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  const Cloud one(geometry::Points(5, Eigen::Vector3d::UnitZ()));
  const Normals normals = EstimateNormals(one);
  EXPECT_FALSE(FitPlane(one));
  EXPECT_FALSE(FitCylinder(one, normals));
  const Cloud two(geometry::Points{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}});
  const auto apart = RegisterPointToPlane(one, two, Eigen::Isometry3d::Identity(), {{}, 2.0});
  EXPECT_FALSE(apart.converged);
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST(Cloud, OptionsOutOfRangeAreNamed) {
  const Cloud cloud(geometry::Points{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}});
  const Normals normals = EstimateNormals(cloud, {.radius_m = 2.0});
  const Eigen::Isometry3d X_TS = Eigen::Isometry3d::Identity();
  EXPECT_THROW(Cloud({}, Eigen::Vector3d(0, 0, kNaN)), std::invalid_argument);
  EXPECT_THROW(EstimateNormals(cloud, {.radius_m = 0.0}), std::invalid_argument);
  EXPECT_THROW(FitPlane(cloud, {.max_draws = 0}), std::invalid_argument);
  EXPECT_THROW(FitPlane(cloud, {.confidence = 1.0}), std::invalid_argument);
  EXPECT_THROW(FitCylinder(cloud, {}), std::invalid_argument);
  EXPECT_THROW(FitCylinder(cloud, normals, {.min_radius_m = 0.3}), std::invalid_argument);
  EXPECT_THROW(StatisticalFilter(cloud, {.neighbors = 0}), std::invalid_argument);
  EXPECT_THROW(RadiusFilter(cloud, {.min_neighbors = 0}), std::invalid_argument);
  EXPECT_THROW(EuclideanClusters(cloud, {.tolerance_m = -1.0}), std::invalid_argument);
  EXPECT_THROW(GrowRegions(cloud, normals, {.max_angle_rad = 2.0}), std::invalid_argument);
  EXPECT_THROW(GrowRegions(cloud, {}), std::invalid_argument);
  EXPECT_THROW(SegmentByLocalConvexity(cloud, {.voxel_m = 0.01, .seed_m = 0.01}),
               std::invalid_argument);
  EXPECT_THROW(SegmentByLocalConvexity(Cloud(geometry::Points{{0, 0, -1}}), {.camera_depth = true}),
               std::invalid_argument);
  EXPECT_THROW(RegisterGeneralized(cloud, cloud, X_TS), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::pcl_bridge
