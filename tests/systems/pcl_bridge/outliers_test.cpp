#include "pcl_bridge/outliers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "noisy_surfaces.h"

namespace rangegrasp::pcl_bridge {
namespace {

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

/// Compares with a verdict a point but where the point is within rounding of the bound.
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

TEST_P(SeededOutliers, RadiusFilterIsTheBruteForceOne) {
  base::Rng rng(GetParam());
  const geometry::Points points = MakePoints(rng);
  const RadiusFilterOptions options{.radius_m = 0.01, .min_neighbors = 5};
  std::vector<double> needed_radius;
  for (std::size_t i = 0; i < points.size(); ++i) needed_radius.push_back(Distances(points, i)[4]);
  ExpectKept(RadiusFilter(Cloud(points), options), needed_radius, options.radius_m);
}

TEST(Outliers, CloudsOfFewPointsPass) {
  for (std::size_t n = 1; n < 5; ++n) {
    base::Rng rng(n);
    const Cloud cloud(geometry::samples::RandomPoints(n, 0.1, rng));
    EXPECT_EQ(StatisticalFilter(cloud, {.neighbors = 50, .max_deviations = 10.0}).size(), n);
    EXPECT_TRUE(RadiusFilter(cloud, {.radius_m = 1.0, .min_neighbors = 4}).empty());
  }
}

}  // namespace
}  // namespace rangegrasp::pcl_bridge
