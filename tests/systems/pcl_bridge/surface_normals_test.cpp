#include "pcl_bridge/surface_normals.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/normals.h"
#include "noisy_surfaces.h"

namespace rangegrasp::pcl_bridge {
namespace {

class SeededNormals : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededNormals, ::testing::Range<std::uint64_t>(0, 20));

TEST_P(SeededNormals, AreThoseOfGeometryButForRounding) {
  base::Rng rng(GetParam());
  const Eigen::Vector3d center = samples::RandomPoint(0.3, rng);
  const Eigen::Vector3d normal = samples::RandomDirection(rng);
  const Eigen::Vector3d sensor = center + 0.7 * normal;
  const auto points = samples::OnSquare(center, normal, 0.05, 0.0005, 2000, rng);
  const auto ours = geometry::EstimateNormals(points, geometry::KdTree(points), 0.01, sensor);
  const Normals found = EstimateNormals(Cloud(points, sensor), {.radius_m = 0.01});
  // The library takes the eigenvector in closed form and single precision: mostly to 1e-4 rad, but
  // a few in ten thousand, where rounding meets a neighborhood of poor shape, to 0.01 rad only.
  std::size_t far = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double off = (ours[i] - found.directions[i]).norm();
    EXPECT_LT(off, 0.01) << i;
    far += off > 1e-4 ? 1 : 0;
    EXPECT_GT(found.directions[i].dot(sensor - points[i]), 0.0) << i;
  }
  EXPECT_LT(far, points.size() / 100);
}

TEST_P(SeededNormals, OnATubeArePerpendicularToItsAxisAndTurnTowardsTheSensor) {
  base::Rng rng(GetParam());
  const samples::Tube tube{{0.1, 0.2, 0.5}, samples::RandomDirection(rng), 0.04, 0.1};
  const auto points = samples::OnTube(tube, 0.0, 8000, rng);
  const Normals found = EstimateNormals(Cloud(points, tube.center), {.radius_m = 0.006});
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d along = (points[i] - tube.center).dot(tube.axis) * tube.axis;
    if (along.norm() > tube.half_length_m - 0.006) continue;  // no surface on one side
    const Eigen::Vector3d inwards = (tube.center + along - points[i]).normalized();
    // Over 6 mm the tube bends by 6 / 40 rad; unevenly spread points tilt the normal by a part of
    // it.
    EXPECT_GT(found.directions[i].dot(inwards), std::cos(0.15)) << i;
    EXPECT_LT(found.curvature[i], 0.02) << i;
  }
}

TEST(Normals, ThreePointsMakeOneAndTwoDoNot) {
  const geometry::Points points = {
      {0, 0, 1}, {0.001, 0, 1}, {0, 0.001, 1}, {1, 0, 1}, {1.001, 0, 1}};
  const Normals normals = EstimateNormals(Cloud(points));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT((normals.directions[i] + Eigen::Vector3d::UnitZ()).norm(), 1e-3);
    EXPECT_NEAR(normals.curvature[i], 0.0, 1e-6);
  }
  for (std::size_t i = 3; i < 5; ++i) EXPECT_FALSE(normals.directions[i].allFinite());
}

}  // namespace
}  // namespace rangegrasp::pcl_bridge
