#include "seam/stitching/internal/seam_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/rng.h"
#include "base/units.h"

namespace rangegrasp::seam {
namespace {

double Wave(double y) { return 0.01 * std::sin(2.0 * base::kPi * y / 0.2); }

std::vector<Point> Sample(double (*x)(double), double spacing_m, double length_m) {
  std::vector<Point> points;
  for (int i = 0; i * spacing_m <= length_m; ++i)
    points.emplace_back(x(i * spacing_m), i * spacing_m);
  return points;
}

double DistanceTo(const std::vector<Point>& line, const Point& p) {
  double nearest = 1e9;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Point along = line[i] - line[i - 1];
    const double t = std::clamp((p - line[i - 1]).dot(along) / along.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - line[i - 1] - t * along).norm());
  }
  return nearest;
}

class SeededSeamPath : public testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededSeamPath, testing::Range<std::uint64_t>(0, 20));

TEST_P(SeededSeamPath, SmoothingHalvesTheNoise) {
  base::Rng rng(GetParam());
  auto points = Sample(Wave, 3e-3, 0.4);
  double before = 0.0, after = 0.0;
  for (Point& p : points) p.x() += 0.1e-3 * rng.Normal();
  const auto smooth = SmoothEdge(points);
  ASSERT_EQ(smooth.size(), points.size());
  for (std::size_t i = 5; i + 5 < points.size(); ++i) {
    before += std::pow(points[i].x() - Wave(points[i].y()), 2);
    after += std::pow(smooth[i].x() - Wave(smooth[i].y()), 2);
  }
  // A parabola through 11 points leaves 0.21 of the variance at its middle. The residual-dependent
  // weights and the choice between windows lose some of that.
  EXPECT_LT(after, 0.45 * before);
}

TEST_P(SeededSeamPath, AQuarterOfGrossOutliersDoesNotMatter) {
  base::Rng rng(GetParam());
  auto points = Sample(Wave, 3e-3, 0.4);
  for (Point& p : points) {
    p.x() += 0.05e-3 * rng.Normal();
    if (rng.Uniform() < 0.25) p.x() += rng.Uniform(-20e-3, 20e-3);
  }
  const auto smooth = SmoothEdge(points);
  ASSERT_GT(smooth.size(), points.size() / 2);
  std::vector<double> error;
  for (const Point& p : smooth) error.push_back(std::abs(p.x() - Wave(p.y())));
  std::sort(error.begin(), error.end());
  EXPECT_LT(error[error.size() * 9 / 10], 0.2e-3);
}

TEST_P(SeededSeamPath, PointsWithoutAnyOrderAreNotBelieved) {
  base::Rng rng(GetParam());
  auto points = Sample(Wave, 3e-3, 0.4);
  for (Point& p : points) p.x() = rng.Uniform(-40e-3, 40e-3);
  EXPECT_LT(SmoothEdge(points).size(), points.size() / 10);
}

TEST(SeamPath, AJumpStaysSharp) {
  const auto points = Sample([](double y) { return y < 0.2 ? 0.0 : -0.01; }, 3e-3, 0.4);
  const auto smooth = SmoothEdge(points);
  ASSERT_GE(smooth.size(), points.size() - 4);
  for (const Point& p : smooth) EXPECT_NEAR(p.x(), p.y() < 0.2 ? 0.0 : -0.01, 1e-5);
}

TEST(SeamPath, TooFewPointsAreNoEdge) {
  EXPECT_TRUE(SmoothEdge({}).empty());
  EXPECT_TRUE(SmoothEdge(Sample(Wave, 3e-3, 0.010)).empty());
  EXPECT_FALSE(SmoothEdge(Sample(Wave, 3e-3, 0.030)).empty());
}

// They determine no parabola.
TEST(SeamPath, PointsAtOnePlaceAreNoEdge) {
  const std::vector<Point> same(20, Point(1e-3, 0.1));
  EXPECT_TRUE(SmoothEdge(same).empty());
}

// Checks the definition of an offset curve by brute force.
TEST(SeamPath, TheOffsetCurveKeepsItsDistanceOnTheLowSide) {
  const auto bump = [](double y) {
    const double d = 0.02 * 0.02 - (y - 0.2) * (y - 0.2);
    return d > 0.0 ? -std::sqrt(d) : 0.0;
  };
  for (const auto& edge : {Sample(Wave, 1e-3, 0.4), Sample(bump, 1e-3, 0.4)}) {
    for (double y = 0.02; y < 0.38; y += 0.37e-3) {
      const Point p(OffsetX(edge, 5e-3, y), y);
      EXPECT_NEAR(DistanceTo(edge, p), 5e-3, 1e-9);
      const auto at = std::lower_bound(edge.begin(), edge.end(), y,
                                       [](const Point& q, double v) { return q.y() < v; });
      EXPECT_LT(p.x(), at->x());
    }
  }
}

TEST(SeamPath, WhereNoEdgeIsNearThereIsNoOffsetCurve) {
  EXPECT_TRUE(std::isnan(OffsetX(Sample(Wave, 1e-3, 0.1), 5e-3, 0.11)));
  EXPECT_TRUE(std::isnan(OffsetX({}, 5e-3, 0.0)));
}

TEST(SeamPath, ExtendingGoesOnStraight) {
  const auto edge = Extend(Sample([](double y) { return 0.3 * y; }, 3e-3, 0.1), 0.05, 0.02);
  EXPECT_NEAR(edge.front().x(), 0.3 * edge.front().y(), 1e-12);
  EXPECT_NEAR(edge.front().y(), -0.05, 1e-12);
  EXPECT_NEAR(edge.back().x(), 0.3 * edge.back().y(), 1e-12);
  EXPECT_NEAR(edge.back().y(), 0.099 + 0.02, 1e-12);
}

TEST(SeamPath, ResampledPointsLieOnTheLineAtEqualDistances) {
  const std::vector<Point> line = {{0, 0}, {3, 4}, {3, 4.2}, {10, 4.2}};
  const auto points = Resample(line, 0.7);
  for (const Point& p : points) EXPECT_LT(DistanceTo(line, p), 1e-12);
  EXPECT_EQ(points.front(), line.front());
  EXPECT_TRUE(points.back().isApprox(line.back()));
  EXPECT_NEAR((points[3] - points[2]).norm(), 0.7, 1e-12);  // both on the first leg
  EXPECT_EQ(points.size(), 19U);                            // 12.2 / 0.7 and both ends
}

TEST(SeamPath, RoundingKeepsStraightLinesAndEnds) {
  const std::vector<Point> line = Sample([](double y) { return 2.0 * y; }, 1e-3, 0.05);
  const auto round = RoundCorners(line, 5);
  ASSERT_EQ(round.size(), line.size());
  for (std::size_t i = 0; i < line.size(); ++i) EXPECT_LT((round[i] - line[i]).norm(), 1e-12);
}

}  // namespace
}  // namespace rangegrasp::seam
