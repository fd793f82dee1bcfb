#include "pcl_bridge/ransac.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>

#include "noisy_surfaces.h"

namespace rangegrasp::pcl_bridge {
namespace {

using samples::Append;
using samples::RandomDirection;
using samples::RandomPoint;

constexpr double kSigma_m = 0.0003;
/// Single precision, of coordinates below 1 m, over a few operations.
constexpr double kFloat = 2e-6;

class SeededModels : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededModels, ::testing::Range<std::uint64_t>(0, 20));

struct PlaneScene {
  geometry::Points points;  ///< 1000 of the plane, then 400 anywhere
  Eigen::Vector3d center;
  Eigen::Vector3d normal;
};
constexpr double kHalf_m = 0.1;
constexpr std::size_t kOnPlane = 1000;

PlaneScene MakePlaneScene(base::Rng& rng) {
  PlaneScene scene;
  scene.center = RandomPoint(0.3, rng);
  scene.normal = RandomDirection(rng);
  scene.points = samples::OnSquare(scene.center, scene.normal, kHalf_m, kSigma_m, kOnPlane, rng);
  for (int i = 0; i < 400; ++i) scene.points.push_back(scene.center + RandomPoint(kHalf_m, rng));
  return scene;
}

// Standard errors of a least-squares plane: sigma / sqrt(n) across it, times sqrt(3) / half for its
// angles. Points anywhere that happen to be within the 2 mm add 400 (2 / 100) = 8 with 1.2 mm each:
// their share shifts the plane by 8 / 1000 * 1.2 mm / sqrt(8) = 3 um, a third of sigma / sqrt(n).
TEST_P(SeededModels, PlaneIsTheTrueOneWithinItsStandardErrors) {
  base::Rng rng(GetParam());
  const PlaneScene scene = MakePlaneScene(rng);
  const Eigen::Vector3d sensor = scene.center + 0.5 * scene.normal + RandomPoint(0.2, rng);
  const auto fit = FitPlane(Cloud(scene.points, sensor));
  ASSERT_TRUE(fit);
  const double across = 6.0 * kSigma_m / std::sqrt(static_cast<double>(kOnPlane)) + kFloat;
  EXPECT_NEAR(fit->plane.Distance(scene.center), 0.0, across);
  EXPECT_NEAR(fit->plane.normal.norm(), 1.0, 1e-12);
  EXPECT_LT((fit->plane.normal - scene.normal).norm(), std::sqrt(3.0) * across / kHalf_m);
  EXPECT_GT(fit->plane.Distance(sensor), 0.0);
}

TEST_P(SeededModels, PlanesInliersAreExactlyThePointsWithinTheDistance) {
  base::Rng rng(GetParam());
  const PlaneScene scene = MakePlaneScene(rng);
  const PlaneOptions options;
  const auto fit = FitPlane(Cloud(scene.points), options);
  ASSERT_TRUE(fit);
  EXPECT_TRUE(std::ranges::is_sorted(fit->inliers));
  for (std::uint32_t i = 0; i < scene.points.size(); ++i) {
    const double distance = std::abs(fit->plane.Distance(scene.points[i]));
    if (std::abs(distance - options.inlier_distance_m) < kFloat) continue;
    EXPECT_EQ(std::ranges::binary_search(fit->inliers, i), distance < options.inlier_distance_m)
        << i;
  }
}

// The library's refit (Levenberg-Marquardt in single precision, with numeric derivatives) ends
// before the least-squares optimum: it is held to the noise of one point, where the optimum's
// standard error would be sigma / sqrt(n) = 6 um. Along the axis sigma counts on the lever
// half_length / sqrt(3).
TEST_P(SeededModels, CylinderIsTheTrueOneWithinItsStandardErrors) {
  base::Rng rng(GetParam());
  const samples::Tube tube{RandomPoint(0.2, rng), RandomDirection(rng), rng.Uniform(0.02, 0.05),
                           0.06};
  constexpr std::size_t kOnTube = 3000;
  geometry::Points points = samples::OnTube(tube, kSigma_m, kOnTube, rng);
  for (int i = 0; i < 300; ++i) points.push_back(tube.center + RandomPoint(0.15, rng));
  const Cloud cloud(points, tube.center + 1.0 * RandomDirection(rng));
  const Normals normals = EstimateNormals(cloud, {.radius_m = 0.008});
  const auto fit = FitCylinder(cloud, normals);
  ASSERT_TRUE(fit);
  const Cylinder& found = fit->cylinder;
  EXPECT_NEAR(found.radius_m, tube.radius_m, kSigma_m);
  EXPECT_NEAR(found.axis.norm(), 1.0, 1e-12);
  EXPECT_LT(found.axis.cross(tube.axis).norm(), std::sqrt(3.0) * kSigma_m / tube.half_length_m);
  EXPECT_LT((found.point - tube.center).cross(tube.axis).norm(), kSigma_m);
  // Beside the middle: the mean of n uniform places has the error half_length / sqrt(3 n).
  EXPECT_LT(std::abs((found.point - tube.center).dot(tube.axis)),
            6.0 * tube.half_length_m / std::sqrt(3.0 * 0.8 * kOnTube));
  const auto on_tube =
      std::ranges::count_if(fit->inliers, [](std::uint32_t i) { return i < kOnTube; });
  EXPECT_GT(on_tube,
            0.8 * kOnTube);  // ends and neighbors of stray points have normals that are off
}

struct Drawn {
  std::optional<geometry::PlaneFit> plane;
  std::optional<CylinderFit> cylinder;
};

/// So few draws that they decide.
Drawn FitWithFewDraws(std::uint64_t seed) {
  base::Rng rng(seed);
  const Cloud cloud(MakePlaneScene(rng).points);
  const CylinderOptions wide{.max_draws = 3, .inlier_distance_m = 0.01, .max_radius_m = 1.0};
  return {FitPlane(cloud, {.max_draws = 3}),
          FitCylinder(cloud, EstimateNormals(cloud, {.radius_m = 0.02}), wide)};
}

// A generator that is seeded by the clock, as the library's can be, gives the same within a second.
TEST(Models, SameCloudGivesTheSameModelsASecondLater) {
  constexpr std::uint64_t kClouds = 10;
  std::vector<Drawn> first;
  for (std::uint64_t seed = 0; seed < kClouds; ++seed) first.push_back(FitWithFewDraws(seed));
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  for (std::uint64_t seed = 0; seed < kClouds; ++seed) {
    const Drawn again = FitWithFewDraws(seed);
    ASSERT_TRUE(again.plane && first[seed].plane);
    EXPECT_EQ(again.plane->plane.normal, first[seed].plane->plane.normal);
    EXPECT_EQ(again.plane->inliers, first[seed].plane->inliers);
    ASSERT_EQ(again.cylinder.has_value(), first[seed].cylinder.has_value());
    if (!again.cylinder) continue;
    EXPECT_EQ(again.cylinder->cylinder.axis, first[seed].cylinder->cylinder.axis);
    EXPECT_EQ(again.cylinder->inliers, first[seed].cylinder->inliers);
  }
}

TEST(Models, CylinderKeepsToTheRadiiAskedFor) {
  base::Rng rng(3);
  const samples::Tube tube{{0, 0, 0.5}, Eigen::Vector3d::UnitX(), 0.03, 0.05};
  const Cloud cloud(samples::OnTube(tube, 0.0, 2000, rng));
  const Normals normals = EstimateNormals(cloud, {.radius_m = 0.008});
  EXPECT_TRUE(FitCylinder(cloud, normals, {.min_radius_m = 0.02, .max_radius_m = 0.04}));
  const auto large = FitCylinder(cloud, normals, {.min_radius_m = 0.05, .max_radius_m = 0.1});
  EXPECT_TRUE(!large || large->inliers.size() < 1000u);
}

}  // namespace
}  // namespace rangegrasp::pcl_bridge
