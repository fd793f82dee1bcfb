#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "geometry/kd_tree.h"
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
  geometry::Indices finite;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].allFinite()) finite.push_back(static_cast<std::uint32_t>(i));
  }
  const auto clusters = EuclideanClusters(points, samples::kOrigin, {.tolerance_m = 0.05});
  ASSERT_EQ(clusters.size(), 1u);
  EXPECT_EQ(clusters.front(), finite);
  const geometry::Points normals = EstimateNormals(points, samples::kOrigin, 0.02);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(normals[i].allFinite(), points[i].allFinite()) << i;
  }
  const auto segment = SegmentByLocalConvexity(points, samples::kOrigin);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) {
      EXPECT_EQ(segment[i], -1) << i;
    }
  }
}

// At 1000 m single precision resolves 0.06 mm; relative to an origin nearby it resolves 0.1 um.
TEST(Cloud, KeepsItsPrecisionFarFromTheFramesOrigin) {
  base::Rng rng(2);
  const Eigen::Vector3d far(1000.0, -2000.0, 500.0);
  const Eigen::Vector3d normal = Eigen::Vector3d(1.0, 2.0, -3.0).normalized();
  const auto points = samples::OnSquare(far, normal, 0.01, 0.0, 500, rng);
  for (const auto& n : EstimateNormals(points, far + 0.5 * normal, 0.005)) {
    EXPECT_LT((n - normal).norm(), 0.002);
  }
}

TEST(Cloud, NothingIsFoundInNothing) {
  for (const geometry::Points& points :
       {geometry::Points{}, geometry::Points(3, Eigen::Vector3d(0, 0, kNaN))}) {
    const geometry::Points normals = EstimateNormals(points, samples::kOrigin);
    EXPECT_FALSE(FitCylinder(points, samples::kOrigin, normals));
    EXPECT_TRUE(EuclideanClusters(points, samples::kOrigin).empty());
    EXPECT_EQ(SegmentByLocalConvexity(points, samples::kOrigin),
              std::vector<std::int32_t>(points.size(), -1));
  }
}

// The library prints messages about failed fits and missing neighbors.
TEST(Cloud, SilencesTheLibrary) {
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  const geometry::Points one(5, Eigen::Vector3d::UnitZ());
  const geometry::Points normals = EstimateNormals(one, samples::kOrigin);
  EXPECT_FALSE(FitCylinder(one, samples::kOrigin, normals));
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST(Cloud, WhatDoesNotFitIsRefused) {
  const geometry::Points points = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  EXPECT_THROW(EstimateNormals(points, Eigen::Vector3d(0, 0, kNaN)), std::invalid_argument);
  EXPECT_THROW(FitCylinder(points, samples::kOrigin, {}), std::invalid_argument);
  EXPECT_THROW(SegmentByLocalConvexity(geometry::Points{{0, 0, -1}}, samples::kOrigin,
                                       {.camera_depth = true}),
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
  const auto ours = geometry::EstimateNormals(points, geometry::KdTree(points), 0.01,
                                              geometry::Points{sensor}, {});
  const geometry::Points found = EstimateNormals(points, sensor, 0.01);
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
  const geometry::Points found = EstimateNormals(points, tube.center, 0.006);
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
  const geometry::Points normals = EstimateNormals(points, samples::kOrigin);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT((normals[i] + Eigen::Vector3d::UnitZ()).norm(), 1e-3);
  }
  for (std::size_t i = 3; i < 5; ++i) EXPECT_FALSE(normals[i].allFinite());
}

}  // namespace
}  // namespace rangegrasp::pcl_bridge
