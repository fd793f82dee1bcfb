#include "experiment/statistics.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <stdexcept>

#include "experiment/sample_record.h"

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

TEST(MeanRateInterval, IsWilsonsOfOneRate) {
  const auto interval = MeanRateInterval({{7, 9}, {0, 0}});
  const auto [low, high] = WilsonInterval(7, 9);
  ASSERT_TRUE(interval);
  EXPECT_DOUBLE_EQ(interval->first, low);
  EXPECT_DOUBLE_EQ(interval->second, high);
  EXPECT_FALSE(MeanRateInterval({{0, 0}}));
}

TEST(MeanRateInterval, IsThatOfAllTrialsWhereEachRateHasAsMany) {
  EXPECT_EQ(MeanRateInterval({{10, 10}, {0, 10}}), WilsonInterval(10, 20));
  const auto four = MeanRateInterval({{10, 10}, {10, 10}, {10, 10}, {10, 10}});
  EXPECT_NEAR(four->first, WilsonInterval(40, 40).first, 1e-12);
  EXPECT_EQ(four->second, 1.0);
}

// All outcomes of three rates with 5, 10 and 20 trials, weighted by their probability. With so few
// trials and different rates, the coverage is not exactly 95 % but rather higher.
TEST(MeanRateInterval, CoversTheMeanInNineteenOfTwenty) {
  const auto chance = [](int k, int n, double p) {
    return std::exp(std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0)) *
           std::pow(p, k) * std::pow(1.0 - p, n - k);
  };
  for (const auto& p : {std::array{0.5, 0.9, 0.97}, {0.2, 0.5, 0.8}, {0.95, 0.95, 0.95}}) {
    double covered = 0.0;
    for (int a = 0; a <= 5; ++a) {
      for (int b = 0; b <= 10; ++b) {
        for (int c = 0; c <= 20; ++c) {
          const auto interval = MeanRateInterval({{a, 5}, {b, 10}, {c, 20}});
          const double mean = (p[0] + p[1] + p[2]) / 3.0;
          if (mean < interval->first || mean > interval->second) continue;
          covered += chance(a, 5, p[0]) * chance(b, 10, p[1]) * chance(c, 20, p[2]);
        }
      }
    }
    EXPECT_GT(covered, 0.93);
  }
}

TEST(ClusteredInterval, IsWilsonsWhereClustersDifferAsIndependentTrialsDo) {
  // k of n = 4 per cluster has the frequencies of the binomial with p = 1/2: 1, 4, 6, 4, 1 of 16.
  std::vector<Count> clusters;
  for (const int k : {0, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 3, 3, 3, 3, 4}) clusters.push_back({k, 4});
  const auto [low, high] = ClusteredInterval(clusters);
  const auto [wilson_low, wilson_high] = WilsonInterval(32, 64);
  // The clusters' variance has 15 instead of 16: 3 % of the half width of 0.12.
  EXPECT_NEAR(low, wilson_low, 0.005);
  EXPECT_NEAR(high, wilson_high, 0.005);
}

TEST(ClusteredInterval, ClustersThatGoTogetherCountAsOneTrialEach) {
  std::vector<Count> clusters;
  for (int i = 0; i < 10; ++i) clusters.push_back({i < 4 ? 12 : 0, 12});
  const auto [low, high] = ClusteredInterval(clusters);
  const auto [wilson_low, wilson_high] = WilsonInterval(4, 10);
  EXPECT_DOUBLE_EQ(low, wilson_low);
  EXPECT_DOUBLE_EQ(high, wilson_high);
}

TEST(ClusteredInterval, WhereAllSucceedTheNumberOfClustersCounts) {
  const std::vector<Count> clusters(20, Count{12, 12});
  const auto [low, high] = ClusteredInterval(clusters);
  EXPECT_DOUBLE_EQ(low, WilsonInterval(20, 20).first);
  EXPECT_EQ(high, 1.0);
}

TEST(ClusteredInterval, RefusesWhatIsNoCount) {
  EXPECT_THROW(ClusteredInterval({}), std::invalid_argument);
  EXPECT_THROW(ClusteredInterval({{3, 2}}), std::invalid_argument);
}

TEST(EffectiveTrials, AreTheClustersWhereTheseAgreeAndAllTrialsWhereTheyDifferByChance) {
  EXPECT_DOUBLE_EQ(EffectiveTrials({{12, 12}, {12, 12}, {12, 12}}), 3.0);
  EXPECT_DOUBLE_EQ(EffectiveTrials({{0, 1}, {1, 1}, {1, 1}, {0, 1}, {0, 1}}),
                   5.0);  // never fewer
}

// The design effect is 0, so the trials are equivalent to infinitely many, at most to all.
TEST(EffectiveTrials, AreAllTrialsWhereEachClusterHasTheSameRate) {
  EXPECT_DOUBLE_EQ(EffectiveTrials({{5, 10}, {5, 10}}), 20.0);
  EXPECT_DOUBLE_EQ(EffectiveTrials({{1, 3}, {2, 6}, {0, 0}}), 9.0);
  EXPECT_DOUBLE_EQ(EffectiveTrials({{5, 10}}), 1.0);  // one cluster has nothing to differ from
}

TEST(McNemar, IsTheTwoSidedBinomialTail) {
  EXPECT_DOUBLE_EQ(McNemarExact(0, 0), 1.0);
  EXPECT_NEAR(McNemarExact(0, 5), 2.0 / 32.0, 1e-12);
  EXPECT_NEAR(McNemarExact(1, 5), 2.0 * (1.0 + 6.0) / 64.0, 1e-12);
  EXPECT_DOUBLE_EQ(McNemarExact(4, 4), 1.0);
  EXPECT_DOUBLE_EQ(McNemarExact(2, 9), McNemarExact(9, 2));
}

TEST(Fisher, MatchesTheTeaTasting) {
  // Fisher's tea lady has 3 of 4 right: P(at least 3) = 17/70. As "lower" for the other cup: at
  // most 1 of 4 against 3 of 4.
  EXPECT_NEAR(FisherExactLower(1, 4, 3, 4), 17.0 / 70.0, 1e-12);
  EXPECT_NEAR(FisherExactLower(4, 4, 0, 4), 1.0, 1e-12);
}

TEST(Fisher, TwoSidedIsTwiceTheSmallerTailFromWhicheverSideItIsAsked) {
  EXPECT_NEAR(FisherExact(1, 4, 3, 4), 2.0 * 17.0 / 70.0, 1e-12);
  EXPECT_NEAR(FisherExact(3, 4, 1, 4), 2.0 * 17.0 / 70.0, 1e-12);
  EXPECT_DOUBLE_EQ(FisherExact(5, 10, 5, 10), 1.0);
  // All of one sample and none of the other is one of C(20, 10) = 184,756 ways.
  EXPECT_NEAR(FisherExact(10, 10, 0, 10), 2.0 / 184756.0, 1e-15);
  EXPECT_DOUBLE_EQ(FisherExact(0, 0, 3, 4), 1.0);  // nothing was tried
}

TEST(ScoreTest, IsTheNormalTailOfTheDistanceInStandardErrors) {
  // 60 % of 100 against 50 % is two standard errors of 5 %: 2 (1 - Phi(2)) = 0.0455003.
  EXPECT_NEAR(ScoreTest(0.6, 100.0, 0.5), 0.0455003, 1e-7);
  EXPECT_NEAR(ScoreTest(0.4, 100.0, 0.5), 0.0455003, 1e-7);
  EXPECT_DOUBLE_EQ(ScoreTest(1.0, 10.0, 1.0), 1.0);
  // One failure in 10 with an expected rate of 1: half a trial's variance, z = 0.1 / 0.0689.
  EXPECT_NEAR(ScoreTest(0.9, 10.0, 1.0), std::erfc(0.1 / std::sqrt(2.0 * 0.05 * 0.95 / 10.0)),
              1e-12);
  EXPECT_THROW(ScoreTest(1.2, 10.0, 0.5), std::invalid_argument);
  EXPECT_THROW(ScoreTest(0.5, 10.0, 1.2), std::invalid_argument);
  EXPECT_THROW(ScoreTest(0.5, 0.0, 0.5), std::invalid_argument);
}

TEST(PoissonRates, AreABinomialGivenTheirSum) {
  EXPECT_NEAR(PoissonRatesExact(0, 50, 5, 50), 2.0 / 32.0, 1e-12);
  EXPECT_NEAR(PoissonRatesExact(5, 50, 0, 50), 2.0 / 32.0, 1e-12);
  EXPECT_NEAR(PoissonRatesExact(0, 10, 2, 30), 1.0, 1e-12);          // (3/4)^2 > 1/2
  EXPECT_NEAR(PoissonRatesExact(4, 10, 0, 30), 2.0 / 256.0, 1e-12);  // (1/4)^4
  EXPECT_DOUBLE_EQ(PoissonRatesExact(0, 10, 0, 10), 1.0);
  EXPECT_THROW(PoissonRatesExact(1, 0, 1, 1), std::invalid_argument);
}

TEST(StudentTest, MatchesTheClosedFormsOfOneAndTwoDegreesOfFreedom) {
  // Two values give a Cauchy distribution, P(|t| > 1) = 1/2. Three values give
  // P(|t| > x) = 1 - x / sqrt(2 + x^2).
  EXPECT_NEAR(StudentTest({3.0, 0.5, 2}, 2.5), 0.5, 1e-12);
  EXPECT_NEAR(StudentTest({3.0, 0.5, 3}, 4.0), 1.0 - 2.0 / std::sqrt(6.0), 1e-12);
  EXPECT_EQ(StudentTest({3.0, 0.0, 3}, 3.0), 1.0);
  EXPECT_EQ(StudentTest({3.0, 0.0, 3}, 4.0), 0.0);
  EXPECT_THROW(StudentTest({3.0, std::nullopt, 1}, 3.0), std::invalid_argument);
}

Record With(int i, const char* outcome, std::uint64_t seed = 1) {
  Record record = SampleRecord("mug", i, seed);
  record.result.outcome = outcome;
  return record;
}

TEST(Compare, CountsPairsOfTheSameIdAndSeed) {
  const std::vector<Record> a = {With(0, "won"), With(1, "won"), With(2, "lost"), With(3, "lost"),
                                 With(4, "won")};
  const std::vector<Record> b = {With(3, "gone"), With(0, "won"),    With(1, "lost"),
                                 With(2, "won"),  With(4, "won", 2), With(9, "won")};
  const Comparison c = Compare(a, b, "won");
  EXPECT_EQ(c.pairs, 4);  // not 4, whose seed differs, and not 9
  EXPECT_EQ(c.both, 1);
  EXPECT_EQ(c.only_first, 1);
  EXPECT_EQ(c.only_second, 1);
  EXPECT_EQ(c.same_outcome, 1);
  EXPECT_EQ(c.p_value, McNemarExact(1, 1));
}

TEST(Differing, ArePairsThatOneOfThemWonAlone) {
  const std::vector<Record> a = {With(0, "won"), With(1, "won"), With(2, "lost"), With(3, "lost")};
  const std::vector<Record> b = {With(3, "gone"), With(2, "won"), With(0, "won"), With(1, "lost"),
                                 With(4, "won")};
  const std::vector<std::pair<std::size_t, std::size_t>> expected = {{2, 1}, {1, 3}};
  EXPECT_EQ(Differing(a, b, "won"), expected);
}

TEST(Compare, TellsWhichOfTheTwoWonAlone) {
  std::vector<Record> a, b;
  for (int i = 0; i < 8; ++i) {
    a.push_back(With(i, i < 7 ? "won" : "lost"));
    b.push_back(With(i, i < 2 || i == 7 ? "won" : "lost"));
  }
  const Comparison c = Compare(a, b, "won");
  EXPECT_EQ(c.both, 2);
  EXPECT_EQ(c.only_first, 5);
  EXPECT_EQ(c.only_second, 1);
  EXPECT_NEAR(c.p_value, 2.0 * (1.0 + 6.0) / 64.0, 1e-12);  // both tails of six coin tosses
}

TEST(StageTimes, KeepTheOrderAndInterpolate) {
  std::vector<Record> records(3);
  records[0].result.seconds = {{"scan", 1.0}, {"plan", 4.0}};
  records[1].result.seconds = {{"scan", 3.0}};
  records[2].result.seconds = {{"scan", 2.0}};
  const auto times = StageTimes(records);
  ASSERT_EQ(times.size(), 2u);
  EXPECT_EQ(times[0].stage, "scan");
  EXPECT_DOUBLE_EQ(times[0].median_s, 2.0);
  EXPECT_DOUBLE_EQ(times[0].p95_s, 2.9);  // position 0.95 * 2 = 1.9 of 1, 2, 3
  EXPECT_DOUBLE_EQ(times[1].median_s, 4.0);
}

}  // namespace

}  // namespace rangegrasp::experiment
