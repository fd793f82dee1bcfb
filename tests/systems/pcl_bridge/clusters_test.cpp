#include "pcl_bridge/clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>

#include "geometry/union_find.h"
#include "noisy_surfaces.h"

namespace rangegrasp::pcl_bridge {
namespace {

class SeededClusters : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededClusters, ::testing::Range<std::uint64_t>(0, 20));

TEST_P(SeededClusters, EuclideanClustersAreTheComponentsOfPairsWithinTheTolerance) {
  base::Rng rng(GetParam());
  const auto points = geometry::samples::RandomPoints(400, 0.1, rng);
  const EuclideanClusterOptions options{.tolerance_m = 0.017, .min_points = 3};
  geometry::UnionFind sets(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    for (std::uint32_t j = 0; j < i; ++j) {
      if ((points[i] - points[j]).norm() < options.tolerance_m) sets.Unite(i, j);
    }
  }
  std::map<std::uint32_t, geometry::Indices> expected;
  for (std::uint32_t i = 0; i < points.size(); ++i) expected[sets.Find(i)].push_back(i);
  std::erase_if(expected, [](const auto& set) { return set.second.size() < 3; });
  auto clusters = EuclideanClusters(Cloud(points), options);
  EXPECT_TRUE(std::ranges::is_sorted(clusters, std::greater(), &geometry::Indices::size));
  std::vector<geometry::Indices> sorted;
  for (const auto& [root, set] : expected) sorted.push_back(set);
  std::ranges::sort(sorted);
  std::ranges::sort(clusters);
  EXPECT_GT(sorted.size(), 1u);
  EXPECT_EQ(clusters, sorted);
}

// Two walls that meet in a right angle: each is a region; the seam's points belong to either.
TEST_P(SeededClusters, RegionsEndAtAnEdge) {
  base::Rng rng(GetParam());
  constexpr std::size_t kPoints = 3000;
  constexpr double kHalf = 0.05;
  auto points = samples::OnSquare({0, 0, 1}, Eigen::Vector3d::UnitZ(), kHalf, 0.0001, kPoints, rng);
  samples::Append(samples::OnSquare({kHalf, 0, 1 - kHalf}, Eigen::Vector3d::UnitX(), kHalf, 0.0001,
                                    kPoints, rng),
                  points);
  const Cloud cloud(points);
  constexpr double kRadius = 0.006;
  const auto regions =
      GrowRegions(cloud, EstimateNormals(cloud, {.radius_m = kRadius}), {.max_angle_rad = 0.1});
  ASSERT_GE(regions.size(), 2u);
  std::vector<int> region_of(points.size(), -1);
  for (std::size_t r = 0; r < regions.size(); ++r) {
    EXPECT_TRUE(std::ranges::is_sorted(regions[r]));
    for (const auto i : regions[r]) region_of[i] = static_cast<int>(r);
  }
  std::array<std::map<int, std::size_t>, 2> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double from_edge = std::hypot(points[i].x() - kHalf, points[i].z() - 1.0);
    if (from_edge > 2.0 * kRadius) ++found[i < kPoints ? 0 : 1][region_of[i]];
  }
  for (const std::size_t wall : {0, 1}) {
    std::size_t sum = 0;
    for (const auto& [region, count] : found[wall]) sum += count;
    const auto best =
        std::ranges::max_element(found[wall], {}, [](const auto& f) { return f.second; });
    EXPECT_GT(best->second, 0.95 * static_cast<double>(sum));
    EXPECT_GE(best->first, 0);
    EXPECT_FALSE(found[1 - wall].contains(best->first));
  }
}

TEST(Clusters, PointsWithoutANormalAreInNoRegion) {
  base::Rng rng(4);
  auto points = samples::OnSquare({0, 0, 1}, Eigen::Vector3d::UnitZ(), 0.02, 0.0, 1000, rng);
  points.insert(points.begin(), Eigen::Vector3d(5, 5, 5));  // alone: no neighbors, no normal
  const Cloud cloud(points);
  const auto regions = GrowRegions(cloud, EstimateNormals(cloud));
  ASSERT_EQ(regions.size(), 1u);
  EXPECT_EQ(regions.front().front(), 1u);
  EXPECT_EQ(regions.front().size(), 1000u);
}

}  // namespace
}  // namespace rangegrasp::pcl_bridge
