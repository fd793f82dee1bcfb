#include "seam/decision.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/rng.h"

namespace rangegrasp::seam {
namespace {

using base::Rng;

// Brute force over the pairs (0,1), (0,2), (1,2); the closest pair wins, the first one in a tie.
std::optional<double> SlowVote(const std::array<std::optional<int>, kDetectors>& c,
                               double tolerance) {
  std::optional<double> best;
  double nearest = 1e9;
  for (const auto& [a, b] : {std::pair{c[0], c[1]}, {c[0], c[2]}, {c[1], c[2]}}) {
    if (!a || !b || std::abs(*a - *b) > tolerance || std::abs(*a - *b) >= nearest) continue;
    nearest = std::abs(*a - *b);
    best = (*a + *b) / 2.0;
  }
  return best;
}

TEST(VoteTwoOfThree, IsThatOfBruteForceForAllSmallPositions) {
  const auto position = [](int k) { return k == 6 ? std::nullopt : std::optional<int>(k); };
  for (int a = 0; a <= 6; ++a) {
    for (int b = 0; b <= 6; ++b) {
      for (int c = 0; c <= 6; ++c) {
        for (const double tolerance : {0.0, 1.0, 2.5}) {
          const std::array columns = {position(a), position(b), position(c)};
          EXPECT_EQ(VoteTwoOfThree(columns, tolerance), SlowVote(columns, tolerance));
        }
      }
    }
  }
}

constexpr double kInlier_columns = 6.0;

struct LinePrediction {
  double column;
  int inliers;
};

// Brute force: the line of every pair, its inliers and the sum of their squared errors.
LinePrediction SlowPrediction(const std::vector<TimedColumn>& p, double t) {
  std::vector<TimedColumn> best;
  double best_squares = 0.0;
  for (std::size_t a = 0; a < p.size(); ++a) {
    for (std::size_t b = a + 1; b < p.size(); ++b) {
      if (p[a].time_s == p[b].time_s) continue;
      const double slope = (p[b].column - p[a].column) / (p[b].time_s - p[a].time_s);
      std::vector<TimedColumn> inliers;
      double squares = 0.0;
      for (const auto& q : p) {
        const double e = q.column - p[a].column - slope * (q.time_s - p[a].time_s);
        if (std::abs(e) > kInlier_columns) continue;
        inliers.push_back(q);
        squares += e * e;
      }
      if (inliers.size() < best.size()) continue;
      if (inliers.size() == best.size() && squares >= best_squares) continue;
      best = inliers;
      best_squares = squares;
    }
  }
  if (best.empty()) return {p.back().column, 1};
  double n = 0.0, st = 0.0, sc = 0.0, stt = 0.0, stc = 0.0;
  for (const auto& q : best) {
    n += 1.0;
    st += q.time_s;
    sc += q.column;
    stt += q.time_s * q.time_s;
    stc += q.time_s * q.column;
  }
  const double slope = (n * stc - st * sc) / (n * stt - st * st);
  return {(sc - slope * st) / n + slope * t, static_cast<int>(best.size())};
}

TEST(PredictByLine, IsThatOfBruteForce) {
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    Rng rng(seed);
    std::vector<TimedColumn> found;
    const std::size_t n = 2 + rng.Index(11);
    for (std::size_t i = 0; i < n; ++i) {
      found.push_back({0.01 * static_cast<double>(i), rng.Uniform(480.0, 540.0)});
    }
    const auto column = PredictByLine(found, 0.12, kInlier_columns);
    ASSERT_TRUE(column);
    const auto slow = SlowPrediction(found, 0.12);
    // Any two points lie on a line, so with two inliers rounding decides which line wins.
    if (slow.inliers > 2) {
      EXPECT_NEAR(*column, slow.column, 1e-6) << seed;
    }
  }
}

TEST(PredictByLine, FindsALineAmongFortyPercentOutliers) {
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    Rng rng(seed);
    const double slope = rng.Uniform(-300.0, 300.0);
    std::vector<TimedColumn> found;
    for (int i = 0; i < 10; ++i) found.push_back({0.01 * i, 500.0 + slope * 0.01 * i});
    // A line from an outlier so far off passes at most one of the others.
    for (const int i : {1, 3, 6, 8}) {
      found[static_cast<std::size_t>(i)].column +=
          (i % 2 == 0 ? 1 : -1) * rng.Uniform(150.0, 400.0);
    }
    const auto column = PredictByLine(found, 0.1, kInlier_columns);
    ASSERT_TRUE(column);
    EXPECT_NEAR(*column, 500.0 + slope * 0.1, 1e-6) << seed;
  }
}

// A sensor at 100 kHz. Trying every pair of 10,000 votes would take an hour.
TEST(PredictByLine, FindsTheLineOfVeryManyPoints) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    const double slope = rng.Uniform(-300.0, 300.0);
    std::vector<TimedColumn> found;
    for (int i = 0; i < 10'000; ++i) {
      const bool outlier = rng.Uniform() < 0.3;
      const double off = outlier ? rng.Uniform(50.0, 400.0) : rng.Normal();
      found.push_back({1e-5 * i, 500.0 + slope * 1e-5 * i + off});
    }
    const auto prediction = PredictByLine(found, 0.1, kInlier_columns);
    ASSERT_TRUE(prediction);
    EXPECT_NEAR(*prediction, 500.0 + slope * 0.1, 0.5) << seed;
  }
}

TEST(PredictByLine, TakesOnePointAsItIsAndNoneForNothing) {
  EXPECT_FALSE(PredictByLine({}, 1.0, kInlier_columns));
  const std::vector<TimedColumn> one = {{0.5, 123.0}};
  EXPECT_EQ(*PredictByLine(one, 1.0, kInlier_columns), 123.0);
  const std::vector<TimedColumn> same_time = {{0.5, 100.0}, {0.5, 101.0}};
  EXPECT_TRUE(std::isfinite(*PredictByLine(same_time, 1.0, kInlier_columns)));
}

TEST(SumOfWeights, IsEquation316) {
  Rng rng(1);
  std::array<DetectorResult, kDetectors> results;
  for (auto& result : results) {
    for (int i = 0; i < 50; ++i) result.weight.push_back(static_cast<float>(rng.Uniform()));
  }
  const auto sum = SumOfWeights(results);
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_FLOAT_EQ(sum[i], results[0].weight[i] + results[1].weight[i] + results[2].weight[i]);
  }
}

TEST(Bell, IsEquation318) {
  EXPECT_DOUBLE_EQ(Bell(7.0, 7.0, 3.0), 1.0);
  EXPECT_DOUBLE_EQ(Bell(10.0, 7.0, 3.0), std::exp(-0.5));
  EXPECT_DOUBLE_EQ(Bell(1.0, 7.0, 3.0), std::exp(-2.0));
}

// Eq. 3.19: closeness of x to the positions in the history; the latest position counts most.
double Closeness(const std::vector<double>& h, double x, double sigma) {
  double g = 0.0;
  for (std::size_t t = 1; t <= h.size(); ++t) {
    g += static_cast<double>(t) * std::exp(-std::pow(h[t - 1] - x, 2) / (2.0 * sigma * sigma));
  }
  return g;
}

TEST(WeightByHistory, IsEquation320) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Rng rng(seed);
    std::vector<float> weight(300);
    for (float& w : weight) w = static_cast<float>(rng.Uniform(0.0, 3.0));
    std::vector<double> history(1 + rng.Index(12));
    for (double& h : history) h = rng.Uniform(-50.0, 350.0);  // may lie off the line
    const double sigma = rng.Uniform(0.5, 60.0);
    auto weighted = weight;
    WeightByHistory(weighted, history, sigma);
    const auto n = static_cast<double>(history.size());
    for (std::size_t i = 0; i < weight.size(); ++i) {
      const double factor =
          1.0 + Closeness(history, static_cast<double>(i), sigma) / (n * (n + 1.0));
      // The bells are cut off at 5 sigma, where they are below 4e-6. A float near 4.5 is good to a
      // relative error of 1e-7.
      EXPECT_NEAR(weighted[i], static_cast<double>(weight[i]) * factor, 1e-5) << seed;
    }
    // Eq. 3.21: the maximum is at the same column as that of the formula.
    const auto best = std::max_element(weighted.begin(), weighted.end()) - weighted.begin();
    for (std::size_t i = 0; i < weight.size(); ++i) {
      EXPECT_LE(static_cast<double>(weight[i]) *
                    (1.0 + Closeness(history, static_cast<double>(i), sigma) / (n * (n + 1.0))),
                static_cast<double>(weighted[static_cast<std::size_t>(best)]) + 2e-5);
    }
  }
}

TEST(WeightByHistory, AddsAtMostHalf) {
  std::vector<float> weight(200, 2.0F);
  WeightByHistory(weight, std::vector<double>(10, 100.0), 20.0);
  EXPECT_FLOAT_EQ(weight[100], 3.0F);
  EXPECT_FLOAT_EQ(weight[0], 2.0F * (1.0F + 0.5F * std::exp(-12.5F)));
}

// Section 3.5.3, computed by sorting every window.
double SlowStep(const std::vector<float>& f, int column) {
  const int m = static_cast<int>(f.size());
  float low = 1e9F, high = -1e9F;
  for (int i = std::max(0, column - 10); i <= std::min(m - 1, column + 10); ++i) {
    std::vector<float> w(f.begin() + std::max(0, i - 6), f.begin() + std::min(m, i + 7));
    std::sort(w.begin(), w.end());
    low = std::min(low, w[w.size() / 2]);
    high = std::max(high, w[w.size() / 2]);
  }
  return static_cast<double>(high) - static_cast<double>(low);
}

TEST(StepHeight, IsThatOfADirectTranscription) {
  Rng rng(3);
  std::vector<float> f(120);
  for (float& z : f) z = static_cast<float>(1e-3 * rng.Normal());
  for (int column = 0; column < 120; ++column) {
    EXPECT_DOUBLE_EQ(StepHeight(f, column), SlowStep(f, column));
  }
  EXPECT_EQ(StepHeight(f, -1), 0.0);
  EXPECT_EQ(StepHeight(f, 120), 0.0);
}

TEST(StepHeight, MeasuresAStepAndNotAFilament) {
  std::vector<float> f(200, 0.0F);
  for (std::size_t i = 100; i < 200; ++i) f[i] = 0.5e-3F;
  EXPECT_FLOAT_EQ(static_cast<float>(StepHeight(f, 100)), 0.5e-3F);
  for (const std::size_t i : {40U, 41U, 42U}) f[i] = 5e-3F;  // narrower than half the window
  EXPECT_EQ(StepHeight(f, 41), 0.0);
}

}  // namespace
}  // namespace rangegrasp::seam
