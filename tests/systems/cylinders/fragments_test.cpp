#include "cylinders/fragments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "base/rng.h"

namespace rangegrasp::cylinders {
namespace {

geometry::Points RandomPoints(int count, base::Rng& rng) {
  geometry::Points points;
  for (int i = 0; i < count; ++i) {
    const double x = rng.Uniform();
    const double y = rng.Uniform();
    points.emplace_back(x, y, 0.1 * rng.Uniform());
  }
  return points;
}

double NaiveMeanNearest(const geometry::Points& points) {
  double sum = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (k != i) nearest = std::min(nearest, (points[i] - points[k]).norm());
    }
    sum += nearest;
  }
  return sum / static_cast<double>(points.size());
}

TEST(Fragments, MeanNearestDistanceIsThatOfANaiveLoop) {
  base::Rng rng(1);
  const auto points = RandomPoints(200, rng);
  EXPECT_NEAR(MeanNearestDistance(points, geometry::KdTree(points)), NaiveMeanNearest(points),
              1e-12);
  const geometry::Points one = {{0, 0, 0}};
  EXPECT_EQ(MeanNearestDistance(one, geometry::KdTree(one)), 0.0);
}

TEST(Fragments, MeanNeighborDistanceIsThatOfANaiveLoop) {
  base::Rng rng(1);
  const auto points = RandomPoints(200, rng);
  double sum = 0.0;
  int with_neighbors = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double of_one = 0.0;
    int m = 0;
    for (std::size_t t = 0; t < points.size(); ++t) {
      const double d = (points[i] - points[t]).norm();
      if (t == i || d >= 0.1) continue;
      of_one += d;
      ++m;
    }
    if (m == 0) continue;
    sum += of_one / m;
    ++with_neighbors;
  }
  EXPECT_NEAR(MeanNeighborDistance(points, geometry::KdTree(points), 0.1), sum / with_neighbors,
              1e-12);
  const geometry::Points apart = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_EQ(MeanNeighborDistance(apart, geometry::KdTree(apart), 0.1), 0.0);
}

// The recursive flood fill of the text, with eq. 4.16 written out.
std::vector<geometry::Indices> NaiveFloodFill(const geometry::Points& points, double d_ca) {
  std::vector<bool> visited(points.size(), false);
  std::vector<geometry::Indices> fragments;
  std::function<void(std::uint32_t)> fill = [&](std::uint32_t i) {
    visited[i] = true;
    fragments.back().push_back(i);
    for (std::uint32_t w = 0; w < points.size(); ++w) {
      const double dx = points[i].x() - points[w].x();
      const double dy = points[i].y() - points[w].y();
      const double dz = points[i].z() - points[w].z();
      if (!visited[w] && std::sqrt(dx * dx + dy * dy + dz * dz) < d_ca) fill(w);
    }
  };
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (visited[i]) continue;
    fragments.emplace_back();
    fill(i);
    std::ranges::sort(fragments.back());
  }
  return fragments;
}

class SeededFragments : public testing::TestWithParam<double> {};

TEST_P(SeededFragments, AreThoseOfTheRecursiveFloodFill) {
  base::Rng rng(2);
  const auto points = RandomPoints(300, rng);
  auto naive = NaiveFloodFill(points, GetParam() * NaiveMeanNearest(points));
  std::erase_if(naive, [](const auto& fragment) { return fragment.size() < 3; });
  std::stable_sort(naive.begin(), naive.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  EXPECT_EQ(Fragments(points, {.link = GetParam(), .min_points = 3}), naive);
}
INSTANTIATE_TEST_SUITE_P(Links, SeededFragments, testing::Values(1.0, 1.5, 2.0));

TEST(Fragments, ThereAreNoneOfNoPoints) { EXPECT_TRUE(Fragments({}, {}).empty()); }

TEST(Fragments, TwoRimsApartAreTwo) {
  geometry::Points points;
  for (int i = 0; i < 40; ++i) points.emplace_back(0.002 * i, 0.0, 0.0);
  for (int i = 0; i < 30; ++i) points.emplace_back(0.002 * i, 0.05, 0.0);
  const auto fragments = Fragments(points, {});
  ASSERT_EQ(fragments.size(), 2u);
  EXPECT_EQ(fragments[0].size(), 40u);
  EXPECT_EQ(fragments[1].size(), 30u);
  // As printed a point is no neighbor of one at exactly the mean distance.
  EXPECT_TRUE(Fragments(points, {.link = 0.999, .min_points = 2}).empty());
}

}  // namespace
}  // namespace rangegrasp::cylinders
