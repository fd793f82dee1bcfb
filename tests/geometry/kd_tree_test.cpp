#include "geometry/kd_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/random_points.h"

namespace rangegrasp::geometry {
namespace {

using samples::RandomPoint;
using samples::RandomPoints;

/// All points sorted by distance from the query, ties by index.
std::vector<KdTree::Neighbor> BruteForce(PointSpan points, const Eigen::Vector3d& query) {
  std::vector<KdTree::Neighbor> all;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    all.push_back({i, (points[i] - query).squaredNorm()});
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return std::pair(a.squared_distance, a.index) < std::pair(b.squared_distance, b.index);
  });
  return all;
}

class SeededKdTree : public ::testing::TestWithParam<std::uint64_t> {};

class SeededQueries : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  base::Rng rng{GetParam()};
  const Points points = RandomPoints(1 + rng.Index(400), 1.0, rng);
  const KdTree tree{points};
  std::vector<KdTree::Neighbor> found;
};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededQueries, ::testing::Range<std::uint64_t>(0, 20));
INSTANTIATE_TEST_SUITE_P(Seeds, SeededKdTree, ::testing::Range<std::uint64_t>(0, 20));

TEST_P(SeededQueries, NearestIsThatOfABruteForce) {
  for (int q = 0; q < 30; ++q) {
    const Eigen::Vector3d query = RandomPoint(1.2, rng);
    const std::size_t k = rng.Index(20);
    tree.Nearest(query, k, found);
    const auto expected = BruteForce(points, query);
    ASSERT_EQ(found.size(), std::min(k, points.size()));
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].index, expected[i].index);
  }
}

TEST_P(SeededQueries, NearestWithinADistanceIsThatOfABruteForce) {
  for (int q = 0; q < 30; ++q) {
    const Eigen::Vector3d query = RandomPoint(1.2, rng);
    const std::size_t k = rng.Index(20);
    auto expected = BruteForce(points, query);
    const double max = rng.Uniform(0.0, 1.0);
    std::erase_if(expected, [&](const auto& one) { return one.squared_distance > max * max; });
    tree.Nearest(query, k, found, max);
    ASSERT_EQ(found.size(), std::min(k, expected.size()));
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].index, expected[i].index);
  }
}

TEST_P(SeededQueries, WithinAndCountAreThoseOfABruteForce) {
  for (int q = 0; q < 30; ++q) {
    const Eigen::Vector3d query = RandomPoint(1.2, rng);
    const double radius = rng.Uniform(0.0, 1.0);
    tree.Within(query, radius, found);
    Indices indices;
    for (const auto& n : found) indices.push_back(n.index);
    std::sort(indices.begin(), indices.end());
    Indices expected;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      if ((points[i] - query).norm() < radius) expected.push_back(i);
    }
    EXPECT_EQ(indices, expected);
    EXPECT_EQ(tree.CountWithin(query, radius), expected.size());
    const std::size_t limit = rng.Index(10);
    EXPECT_EQ(tree.CountWithin(query, radius, limit), std::min(limit, expected.size()));
  }
}

TEST_P(SeededKdTree, TiesGoToTheSmallerIndexAndAPointFindsItselfFirst) {
  base::Rng rng(GetParam());
  Points points;  // a grid has ties everywhere
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) points.emplace_back(x, y, 0.0);
  }
  const KdTree tree(points);
  std::vector<KdTree::Neighbor> found;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const std::size_t k = 1 + rng.Index(12);
    tree.Nearest(points[i], k, found);
    const auto expected = BruteForce(points, points[i]);
    EXPECT_EQ(found.front().index, i);
    for (std::size_t j = 0; j < k; ++j) EXPECT_EQ(found[j].index, expected[j].index);
  }
}

TEST_P(SeededKdTree, NearestNeighborDistancesAreThoseOfABruteForce) {
  base::Rng rng(GetParam());
  const Points points = RandomPoints(2 + rng.Index(300), 1.0, rng);
  const KdTree tree(points);
  const NeighborDistances distances = NearestNeighborDistances(points, tree);
  double sum = 0.0;
  double high = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double expected = std::sqrt(BruteForce(points, points[i])[1].squared_distance);
    EXPECT_NEAR(distances.each_m[i], expected, 1e-15);
    sum += expected;
    high = std::max(high, expected);
  }
  EXPECT_NEAR(distances.mean_m, sum / static_cast<double>(points.size()), 1e-12);
  EXPECT_NEAR(distances.max_m, high, 1e-15);
}

TEST(KdTree, ATwinIsANeighborAtDistanceZero) {
  const Points points = {{1.0, 2.0, 3.0}, {1.0, 2.0, 3.0}, {2.0, 2.0, 3.0}};
  const NeighborDistances distances = NearestNeighborDistances(points, KdTree(points));
  EXPECT_EQ(distances.each_m, (std::vector<double>{0.0, 0.0, 1.0}));
}

TEST(KdTree, AnEmptyTreeFindsNothing) {
  const KdTree tree(PointSpan{});
  std::vector<KdTree::Neighbor> found{{1, 1.0}};
  tree.Nearest({0.0, 0.0, 0.0}, 3, found);
  EXPECT_TRUE(found.empty());
  tree.Within({0.0, 0.0, 0.0}, 1.0, found);
  EXPECT_TRUE(found.empty());
  EXPECT_EQ(tree.CountWithin({0.0, 0.0, 0.0}, 1.0), 0u);
}

TEST(KdTree, RefusesWhatIsNotFinite) {
  const Points points = {{0.0, 0.0, 0.0}, {std::nan(""), 0.0, 0.0}};
  EXPECT_THROW(KdTree{points}, std::invalid_argument);
  const Points one = {{0.0, 0.0, 0.0}};
  EXPECT_THROW(NearestNeighborDistances(one, KdTree(one)), std::invalid_argument);
}

// Chains along x with interleaved points. Points link up to the given distance and not beyond it, a
// chain of any length is one group, and groups and points keep their order.
TEST(GroupsWithin, AreChainsOfLinksInTheOrderOfTheirFirstPoints) {
  Points points;
  for (int i = 0; i < 20; ++i) {
    points.emplace_back(0.9 * i, 100.0, 0.0);
    points.emplace_back(0.9 * i, 0.0, 0.0);
  }
  points.emplace_back(0.0, 1.1, 0.0);
  const auto groups = GroupsWithin(points, 1.0);
  ASSERT_EQ(groups.size(), 3u);
  ASSERT_EQ(groups[0].size(), 20u);
  ASSERT_EQ(groups[1].size(), 20u);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(groups[0][i], points[2 * i]);
    EXPECT_EQ(groups[1][i], points[2 * i + 1]);
  }
  EXPECT_EQ(groups[2], (Points{points.back()}));
  EXPECT_EQ(GroupsWithin(points, 1.2).size(), 2u);
}

TEST(GroupsWithin, NoPointsAreNoGroups) { EXPECT_TRUE(GroupsWithin({}, 1.0).empty()); }

}  // namespace
}  // namespace rangegrasp::geometry
