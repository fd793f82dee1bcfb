#include "base/rng.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

namespace rangegrasp::base {
namespace {

TEST(Rng, PhiloxMatchesThePublishedVectorForKeyAndCounterZero) {
  // Random123's known answers, philox4x32 10 rounds, counter 0, key 0: 6627e8d5 e169c58d bc57ac4c
  // 9b00dbd8.
  Rng rng(0);
  EXPECT_EQ(rng.Next(), 0xe169c58d6627e8d5u);
}

TEST(Rng, TheSameSeedGivesTheSameDraws) {
  Rng a(42);
  Rng b(42);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(a.Next(), b.Next());
}

TEST(Rng, UniformHasTheMomentsOfAUniform) {
  Rng rng(7);
  const int n = 200000;
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < n; ++i) {
    const double u = rng.Uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    squares += u * u;
  }
  // Five standard errors: 1 / sqrt(12 n) of the mean, sqrt(4 / 45 / n) of the second moment.
  EXPECT_NEAR(sum / n, 0.5, 5.0 / std::sqrt(12.0 * n));
  EXPECT_NEAR(squares / n, 1.0 / 3.0, 5.0 * std::sqrt(4.0 / 45.0 / n));
}

TEST(Rng, BothHalvesOfASeedChangeTheDraws) {
  for (int bit = 0; bit < 64; ++bit) {
    EXPECT_NE(Rng(42).Next(), Rng(42 ^ (std::uint64_t{1} << bit)).Next()) << bit;
  }
}

TEST(Rng, UniformLiesBetweenItsBoundsRoundTheirMiddle) {
  Rng rng(10);
  const int n = 10000;
  const double low = -3.0, high = 5.0;
  double sum = 0.0;
  for (int i = 0; i < n; ++i) {
    const double u = rng.Uniform(low, high);
    ASSERT_GE(u, low);
    ASSERT_LT(u, high);
    sum += u;
  }
  // Five standard errors: sigma = (high - low) / sqrt(12).
  EXPECT_NEAR(sum / n, 1.0, 5.0 * (high - low) / std::sqrt(12.0 * n));
}

TEST(Rng, NormalHasTheMomentsOfANormal) {
  Rng rng(8);
  const int n = 200000;
  double sum = 0.0;
  double squares = 0.0;
  double fourth = 0.0;
  for (int i = 0; i < n; ++i) {
    const double x = rng.Normal();
    sum += x;
    squares += x * x;
    fourth += x * x * x * x;
  }
  EXPECT_NEAR(sum / n, 0.0, 5.0 / std::sqrt(n));
  EXPECT_NEAR(squares / n, 1.0, 5.0 * std::sqrt(2.0 / n));
  EXPECT_NEAR(fourth / n, 3.0, 5.0 * std::sqrt(96.0 / n));
}

TEST(Rng, IndexIsUniformOverItsRange) {
  Rng rng(9);
  const std::size_t bins = 7;
  const int n = 70000;
  std::vector<int> count(bins, 0);
  for (int i = 0; i < n; ++i) ++count.at(rng.Index(bins));
  double chi2 = 0.0;
  for (const int c : count) chi2 += (c - 10000.0) * (c - 10000.0) / 10000.0;
  EXPECT_LT(chi2, 27.9);  // chi-squared with 6 degrees of freedom, p = 1e-4
}

// The range is three quarters of all 64-bit numbers. If a draw were scaled into it carelessly,
// every third number would come twice as often as the others: in one draw of two, not of three.
TEST(Rng, IndexHasNoBiasInRangesOfAnySize) {
  Rng rng(11);
  const std::size_t size = std::size_t{3} << 62;
  const int n = 3000;
  int thirds = 0;
  for (int i = 0; i < n; ++i) {
    const std::size_t index = rng.Index(size);
    ASSERT_LT(index, size);
    thirds += index % 3 == 0 ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(thirds) / n, 1.0 / 3.0, 5.0 * std::sqrt(2.0 / 9.0 / n));
}

TEST(DeriveSeed, ChildrenDiffer) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t parent = 0; parent < 100; ++parent) {
    for (std::uint64_t child = 0; child < 100; ++child) seeds.insert(DeriveSeed(parent, child));
    for (const char* name : {"", "a", "b", "ab", "ba", "scan", "plan"}) {
      seeds.insert(DeriveSeed(parent, name));
    }
  }
  EXPECT_EQ(seeds.size(), 100u * 107u);
}

}  // namespace
}  // namespace rangegrasp::base
