#include "seam/detectors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/rng.h"
#include "base/words.h"

namespace rangegrasp::seam {
namespace {

using base::Rng;

constexpr std::uint64_t kSeeds = 60;

// Rounds a height to a grid of 2^-30 m. Sums, constant offsets and small integer factors are exact
// there, so that a direct transcription can be compared to the last digit.
float OnGrid(double z) {
  return static_cast<float>(std::ldexp(std::round(std::ldexp(z, 30)), -30));
}

std::vector<float> Step(int m, int column, double low, double height) {
  std::vector<float> f(static_cast<std::size_t>(m));
  for (int i = 0; i < m; ++i) {
    f[static_cast<std::size_t>(i)] = static_cast<float>(i < column ? low : low + height);
  }
  return f;
}

// Noise, noise with outliers, steps up and down, slopes, and combinations of them.
std::vector<float> RandomProfile(Rng& rng) {
  const auto m = static_cast<int>(8 + rng.Index(240));
  const double sigma = 1e-4 * rng.Uniform();
  const double outliers = rng.Index(2) == 0 ? 0.0 : 0.05;
  const double slope = rng.Index(3) == 0 ? 2e-6 * rng.Normal() : 0.0;
  std::vector<double> z(static_cast<std::size_t>(m), 1e-3 * rng.Normal());
  for (std::size_t steps = rng.Index(4); steps > 0; --steps) {
    const std::size_t from = rng.Index(z.size());
    const double height = 5e-4 * rng.Normal();
    for (std::size_t i = from; i < z.size(); ++i) z[i] += height;
  }
  std::vector<float> f;
  for (std::size_t i = 0; i < z.size(); ++i) {
    double height = z[i] + slope * static_cast<double>(i);
    height += sigma * rng.Normal();
    if (rng.Uniform() < outliers) height += 1e-3 * rng.Normal();
    f.push_back(OnGrid(std::clamp(height, -7e-3, 7e-3)));  // 2^23 grid steps fit in a float
  }
  return f;
}

// A random profile with a few levels only, so that differences tie and values equal their average.
std::vector<float> CoarseProfile(Rng& rng) {
  auto f = RandomProfile(rng);
  for (float& z : f) z = std::ldexp(std::round(std::ldexp(z, 13)), -13);
  return f;
}

// Each column is one of three neighbouring floats. An average between them must not be rounded.
std::vector<float> NeighbouringFloats(Rng& rng) {
  std::vector<float> f(8 + rng.Index(60));
  for (float& z : f) z = 1.0F + std::ldexp(static_cast<float>(rng.Index(3)), -23);
  return f;
}

std::vector<float> NoisyStep(int m, int column, double height, double sigma, Rng& rng) {
  std::vector<float> f = Step(m, column, 0.0, height);
  for (float& z : f) z = OnGrid(static_cast<double>(z) + sigma * rng.Normal());
  return f;
}

double At(const std::vector<float>& f, int i) {
  return static_cast<double>(f[static_cast<std::size_t>(i)]);
}

// Literal transcription of eq. 3.1 to 3.3.
std::vector<double> DirectModelSums(const std::vector<float>& f) {
  const auto m = static_cast<int>(f.size());
  const double low = *std::min_element(f.begin(), f.end());
  const double high = *std::max_element(f.begin(), f.end());
  std::vector<double> S(f.size(), 0.0);
  for (int j = 1; j < m; ++j) {
    for (int i = 0; i < m; ++i) {
      const double d = At(f, i) - (i < j ? low : high);
      S[static_cast<std::size_t>(j)] += d * d;
    }
  }
  return S;
}

std::vector<int> DirectCandidates(const std::vector<float>& f, std::size_t count) {
  std::vector<int> columns;
  for (int j = 1; j < static_cast<int>(f.size()); ++j) {
    if (At(f, j) != At(f, j - 1)) columns.push_back(j);
  }
  std::stable_sort(columns.begin(), columns.end(), [&](int a, int b) {
    return std::abs(At(f, a) - At(f, a - 1)) > std::abs(At(f, b) - At(f, b - 1));
  });
  columns.resize(std::min(columns.size(), count));
  return columns;
}

// Literal transcription of eq. 3.5 to 3.8, with windows cut off at the ends of the profile.
double DirectVotingSum(const std::vector<float>& f, int j, int n) {
  const auto m = static_cast<int>(f.size());
  double high = -10.0;
  double low = 10.0;
  for (int k = 1; k <= 3; ++k) {
    high = std::max(high, At(f, std::min(j + k, m - 1)));
    low = std::min(low, At(f, std::max(j - k, 0)));
  }
  double sum = 0.0;
  int points = 0;
  for (int i = j - n; i <= j + n; ++i) {
    if (i < 0 || i >= m) continue;
    sum += At(f, i);
    ++points;
  }
  const double a = sum / points;
  double votes = 0.0;
  for (int i = j - n; i <= j + n; ++i) {
    if (i < 0 || i >= m) continue;
    double v = 0.0;
    if (i < j && At(f, i) < a) v = j - i;
    if (i > j && At(f, i) > a) v = i - j;
    votes += std::abs(v);
  }
  return std::abs(high - low) * votes;
}

double Clamped(const std::vector<float>& f, int i) {
  return At(f, std::clamp(i, 0, static_cast<int>(f.size()) - 1));
}

// Literal transcription of eq. 3.12.
std::vector<double> DirectGradientSums(const std::vector<float>& f, int n) {
  std::vector<double> G(f.size(), 0.0);
  for (int i = 0; i < static_cast<int>(f.size()); ++i) {
    for (int k = 1; k <= n; ++k) {
      G[static_cast<std::size_t>(i)] += std::abs(Clamped(f, i + k) - Clamped(f, i - k));
    }
  }
  return G;
}

TEST(ModelFitting, IsTheDirectSumOfSquaredDistances) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Rng rng(seed);
    const auto f = RandomProfile(rng);
    const auto S = DirectModelSums(f);
    const double largest = *std::max_element(S.begin(), S.end());
    const auto result = FitEdgeModel(f);
    ASSERT_TRUE(result.column) << seed;
    ASSERT_EQ(result.weight.size(), f.size());
    EXPECT_EQ(result.weight[0], 0.0F);
    // Weights are floats of at most 1 (half an ulp is 6e-8). The running sums round far less: m
    // terms with 2^-53 each.
    for (std::size_t j = 1; j < f.size(); ++j) {
      ASSERT_NEAR(result.weight[j], 1.0 - S[j] / largest, 1e-7) << "seed " << seed << " j " << j;
    }
    const double least = *std::min_element(S.begin() + 1, S.end());
    EXPECT_LE(S[static_cast<std::size_t>(*result.column)], least + 1e-12 * largest) << seed;
  }
}

TEST(ModelFitting, KeepsItsDigitsFarFromZero) {
  // At 1 m, floats are 6e-8 m apart. Sums of squares about 0 would lose the step of 0.3 mm.
  for (int column = 1; column < 1024; column += 31) {
    EXPECT_EQ(FitEdgeModel(Step(1024, column, 1.0, 3e-4)).column, column);
  }
}

TEST(LocalWeightedVoting, CandidatesAreTheLargestDifferencesInOrder) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Rng rng(seed);
    const auto f = seed % 2 == 0 ? RandomProfile(rng) : CoarseProfile(rng);
    for (const int count : {1, 2, 30, 100, 1000}) {
      EXPECT_EQ(EdgeCandidates(f, count), DirectCandidates(f, static_cast<std::size_t>(count)))
          << "seed " << seed << " count " << count;
    }
  }
}

TEST(LocalWeightedVoting, IsTheDirectVotingSumOverTheCandidates) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Rng rng(seed);
    const auto f = seed % 3 == 0   ? RandomProfile(rng)
                   : seed % 3 == 1 ? CoarseProfile(rng)
                                   : NeighbouringFloats(rng);
    std::vector<double> S(f.size(), 0.0);
    for (const int j : DirectCandidates(f, 30)) {
      S[static_cast<std::size_t>(j)] = DirectVotingSum(f, j, 75);
    }
    const auto best = std::max_element(S.begin(), S.end());
    const auto result = VoteLocally(f);
    if (*best == 0.0) {
      EXPECT_FALSE(result.column) << seed;
      continue;
    }
    EXPECT_EQ(result.column, static_cast<int>(best - S.begin())) << seed;
    ASSERT_EQ(result.weight.size(), f.size());
    for (std::size_t j = 0; j < f.size(); ++j) {
      // Three roundings to float of values of at most 1.
      ASSERT_NEAR(result.weight[j], S[j] / *best, 2e-7) << "seed " << seed << " j " << j;
    }
  }
}

TEST(GradientAccumulation, IsTheDirectSumOverGrowingKernels) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Rng rng(seed);
    const auto f = RandomProfile(rng);
    const int n = std::max(1, static_cast<int>(0.1 * static_cast<double>(f.size())));
    const auto G = DirectGradientSums(f, n);
    const double largest = *std::max_element(G.begin(), G.end());
    const auto result = AccumulateGradients(f);
    ASSERT_TRUE(result.column) << seed;
    // Each of n float additions rounds by at most 2^-24 of the sum. The same holds for the largest
    // sum, and the quotient adds one rounding.
    const double tolerance = (2.0 * n + 1.0) * std::ldexp(1.0, -24);
    for (std::size_t j = 0; j < f.size(); ++j) {
      ASSERT_NEAR(result.weight[j], G[j] / largest, tolerance) << "seed " << seed << " j " << j;
    }
    EXPECT_GE(G[static_cast<std::size_t>(*result.column)], (1.0 - tolerance) * largest) << seed;
  }
}

TEST(GradientAccumulation, AddsInTheOrderOfTheKernelsWhateverTheVectors) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Rng rng(seed);
    const auto f = RandomProfile(rng);
    const int n = std::max(1, static_cast<int>(0.1 * static_cast<double>(f.size())));
    std::vector<float> G(f.size(), 0.0F);
    for (int i = 0; i < static_cast<int>(f.size()); ++i) {
      for (int k = 1; k <= n; ++k) {
        const auto right = static_cast<float>(Clamped(f, i + k));
        G[static_cast<std::size_t>(i)] += std::abs(right - static_cast<float>(Clamped(f, i - k)));
      }
    }
    const float largest = *std::max_element(G.begin(), G.end());
    for (float& g : G) g /= largest;
    EXPECT_EQ(AccumulateGradients(f).weight, G) << seed;
  }
}

TEST(Detectors, AllFindAnIdealStepAtItsFirstHighColumnEverywhere) {
  // This includes the ends: with m columns, every c from 1 to m - 1 is tested.
  for (const int m : {8, 9, 33, 100, 1024}) {
    for (const double height : {1e-6, 3e-4, 1.1e-3, 0.1}) {
      for (const double low : {0.0, -2e-2}) {
        for (int c = 1; c < m; ++c) {
          const auto f = Step(m, c, low, height);
          for (const DetectorResult& result : DetectEdges(f)) {
            ASSERT_EQ(result.column, c) << "m " << m << " height " << height << " low " << low;
          }
        }
      }
    }
  }
}

TEST(Detectors, WeightsLieBetweenZeroAndOne) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Rng rng(seed);
    const auto f = RandomProfile(rng);
    const auto results = DetectEdges(f);
    for (std::size_t d = 0; d < results.size(); ++d) {
      const auto [low, high] =
          std::minmax_element(results[d].weight.begin(), results[d].weight.end());
      EXPECT_GE(*low, 0.0F);
      EXPECT_LE(*high, 1.0F);
      if (!results[d].column) continue;
      EXPECT_EQ(results[d].weight[static_cast<std::size_t>(*results[d].column)], *high)
          << "seed " << seed << " " << base::Word(static_cast<Detector>(d));
    }
  }
}

// The columns that all detectors find; -1 if a detector finds none.
std::vector<int> Columns(const std::vector<float>& f) {
  std::vector<int> columns;
  for (const auto& result : DetectEdges(f)) columns.push_back(result.column.value_or(-1));
  return columns;
}

TEST(Detectors, PositionsDoNotChangeWithAConstantOrAPositiveFactor) {
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Rng rng(seed);
    auto f = NoisyStep(500, static_cast<int>(20 + rng.Index(460)), 5e-4, 5e-5, rng);
    const auto columns = Columns(f);
    auto raised = f;
    for (float& z : raised) z += OnGrid(3e-3);
    EXPECT_EQ(Columns(raised), columns) << seed;
    auto scaled = f;
    for (float& z : scaled) z *= 3.0F;
    EXPECT_EQ(Columns(scaled), columns) << seed;
  }
}

TEST(Detectors, TheMirroredStepIsFoundAtTheMirroredColumn) {
  // A positive step stays positive if it is mirrored and turned upside down. Its first high column
  // c becomes m - c.
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Rng rng(seed);
    const int m = 500;
    const auto f = NoisyStep(m, static_cast<int>(60 + rng.Index(380)), 5e-4, 5e-5, rng);
    std::vector<float> mirrored(f.rbegin(), f.rend());
    for (float& z : mirrored) z = -z;
    const auto there = Columns(f);
    const auto back = Columns(mirrored);
    EXPECT_EQ(back[0], m - there[0]) << seed;
    // Eq. 3.5 looks 3 columns to either side of the column itself, not of its left border.
    EXPECT_NEAR(back[1], m - there[1], 3) << seed;
    // Eq. 3.12 is symmetric about a column.
    EXPECT_EQ(back[2], m - 1 - there[2]) << seed;
  }
}

TEST(Detectors, AllFindAStepOfTenSigma) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Rng rng(seed);
    const int c = static_cast<int>(110 + rng.Index(800));
    const auto columns = Columns(NoisyStep(1024, c, 5e-4, 5e-5, rng));
    // A fixed model moves only if the noise reaches half a step, 5 sigma. Eq. 3.5 reaches 3
    // columns.
    for (const std::size_t d : {0, 1}) EXPECT_NEAR(columns[d], c, 3) << seed << " " << d;
    // Eq. 3.12 loses one step height per column away from the edge. Each of its 102 terms has a
    // standard deviation of sqrt(2) sigma. Those of two columns together have sqrt(2 * 102 * 2)
    // sigma = 20 sigma, or 2 step heights. The tolerance is five times that.
    EXPECT_NEAR(columns[2], c, 10) << seed;
  }
}

TEST(Detectors, AFlatOrTooShortProfileHasNoColumn) {
  for (const int m : {0, 1, 2, 7, 8, 1024}) {
    const std::vector<float> flat(static_cast<std::size_t>(m), 0.0123F);
    for (const auto& result : DetectEdges(flat)) {
      EXPECT_FALSE(result.column) << m;
      EXPECT_EQ(result.weight, std::vector<float>(flat.size(), 0.0F)) << m;
    }
  }
  for (const auto& result : DetectEdges(Step(7, 3, 0.0, 1e-3))) EXPECT_FALSE(result.column);
}

}  // namespace
}  // namespace rangegrasp::seam
