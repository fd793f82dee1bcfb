#include "experiment/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace rangegrasp::experiment {
namespace {

TEST(Wilson, MatchesNewcombesWorkedExamples) {
  // Newcombe 1998, "Two-sided confidence intervals for the single proportion", table I, method 3.
  const auto a = WilsonInterval(81, 263);
  EXPECT_NEAR(a.first, 0.2553, 5e-5);
  EXPECT_NEAR(a.second, 0.3662, 5e-5);
  const auto b = WilsonInterval(15, 148);
  EXPECT_NEAR(b.first, 0.0624, 5e-5);
  EXPECT_NEAR(b.second, 0.1605, 5e-5);
  const auto c = WilsonInterval(0, 20);
  EXPECT_EQ(c.first, 0.0);
  EXPECT_NEAR(c.second, 0.1611, 5e-5);
}

TEST(Wilson, BoundsSolveTheScoreEquation) {
  // Both bounds p satisfy (k/n - p)^2 = z^2 p (1 - p) / n.
  const double z = 1.959963984540054;
  for (int n = 1; n < 60; ++n) {
    for (int k = 1; k < n; ++k) {
      const auto [low, high] = WilsonInterval(k, n);
      for (const double p : {low, high}) {
        const double d = static_cast<double>(k) / n - p;
        EXPECT_NEAR(d * d, z * z * p * (1.0 - p) / n, 1e-12);
      }
    }
  }
}

TEST(Wilson, ReachesItsEndsWhereAllOrNoneSucceed) {
  for (int n = 1; n < 2000; ++n) {
    EXPECT_EQ(WilsonInterval(0, n).first, 0.0) << n;
    EXPECT_EQ(WilsonInterval(n, n).second, 1.0) << n;
  }
}

TEST(Wilson, RejectsImpossibleCounts) {
  EXPECT_THROW(WilsonInterval(1, 0), std::invalid_argument);
  EXPECT_THROW(WilsonInterval(3, 2), std::invalid_argument);
}

TEST(ClusteredInterval, IsWilsonsWhereClustersDifferAsIndependentTrialsDo) {
  // k of n = 4 of each cluster as often as the binomial of p = 1/2 has it: 1, 4, 6, 4, 1 of 16.
  std::vector<Cluster> clusters;
  for (const int k : {0, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 3, 3, 3, 3, 4}) clusters.push_back({k, 4});
  const auto [low, high] = ClusteredInterval(clusters);
  const auto [wilson_low, wilson_high] = WilsonInterval(32, 64);
  // 15 in place of 16 in the clusters' variance: 3 % of the half width of 0.12.
  EXPECT_NEAR(low, wilson_low, 0.005);
  EXPECT_NEAR(high, wilson_high, 0.005);
}

TEST(ClusteredInterval, ClustersThatGoTogetherCountAsOneTrialEach) {
  std::vector<Cluster> clusters;
  for (int i = 0; i < 10; ++i) clusters.push_back({i < 4 ? 12 : 0, 12});
  const auto [low, high] = ClusteredInterval(clusters);
  const auto [wilson_low, wilson_high] = WilsonInterval(4, 10);
  EXPECT_DOUBLE_EQ(low, wilson_low);
  EXPECT_DOUBLE_EQ(high, wilson_high);
}

TEST(ClusteredInterval, WhereAllSucceedTheNumberOfClustersCounts) {
  const std::vector<Cluster> clusters(20, Cluster{12, 12});
  const auto [low, high] = ClusteredInterval(clusters);
  EXPECT_DOUBLE_EQ(low, WilsonInterval(20, 20).first);
  EXPECT_EQ(high, 1.0);
}

TEST(ClusteredInterval, RefusesWhatIsNoCount) {
  EXPECT_THROW(ClusteredInterval({}), std::invalid_argument);
  EXPECT_THROW(ClusteredInterval({{3, 2}}), std::invalid_argument);
}

TEST(McNemar, IsTheTwoSidedBinomialTail) {
  EXPECT_DOUBLE_EQ(McNemarExact(0, 0), 1.0);
  EXPECT_NEAR(McNemarExact(0, 5), 2.0 / 32.0, 1e-12);
  EXPECT_NEAR(McNemarExact(1, 5), 2.0 * (1.0 + 6.0) / 64.0, 1e-12);
  EXPECT_DOUBLE_EQ(McNemarExact(4, 4), 1.0);
  EXPECT_DOUBLE_EQ(McNemarExact(2, 9), McNemarExact(9, 2));
}

TEST(Fisher, MatchesTheTeaTasting) {
  // Fisher's tea lady, 3 of 4 right: P(at least 3) = 17/70; as "lower" of the other cup: at most 1
  // of 4 beside 3 of 4.
  EXPECT_NEAR(FisherExactLower(1, 4, 3, 4), 17.0 / 70.0, 1e-12);
  EXPECT_NEAR(FisherExactLower(4, 4, 0, 4), 1.0, 1e-12);
}

}  // namespace
}  // namespace rangegrasp::experiment
