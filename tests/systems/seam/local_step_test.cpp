#include "seam/local_step.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/rng.h"

namespace rangegrasp::seam {
namespace {

using base::Rng;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

std::size_t StrongestOf(const std::vector<LocalStep>& steps) {
  std::size_t best = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].evidence > steps[best].evidence) best = i;
  }
  return best;
}

// A rising cubic with a step: medians leave it as it is.
std::vector<float> RisingCubic(int columns, int edge, double step_m) {
  std::vector<float> z;
  for (int i = 0; i < columns; ++i) {
    const double u = i / 300.0;
    z.push_back(static_cast<float>(1e-3 * (u + 0.2 * u * u * u) + (i >= edge ? step_m : 0.0)));
  }
  return z;
}

// The same least-squares problem by a QR decomposition.
double HeightByQr(const std::vector<float>& z, int place, int half) {
  std::vector<int> columns;
  const int end = std::min(static_cast<int>(z.size()), place + half);
  for (int i = std::max(0, place - half); i < end; ++i) {
    if (std::isfinite(z[static_cast<std::size_t>(i)])) columns.push_back(i);
  }
  Eigen::MatrixXd A(static_cast<Eigen::Index>(columns.size()), 4);
  Eigen::VectorXd b(A.rows());
  for (int row = 0; row < A.rows(); ++row) {
    const int column = columns[static_cast<std::size_t>(row)];
    const double u = (column + 0.5 - place) / half;
    A.row(row) << 1.0, u, u * u, column >= place ? 1.0 : 0.0;
    b(row) = static_cast<double>(z[static_cast<std::size_t>(column)]);
  }
  return A.colPivHouseholderQr().solve(b)(3);
}

TEST(LocalStep, HeightsAreThoseOfTheLeastSquaresProblem) {
  Rng rng(1);
  auto z = RisingCubic(1024, 420, 0.5e-3);
  for (float& height : z) height = rng.Uniform() < 0.3 ? kNone : height;
  LocalStepOptions options;
  options.half_windows = {60, 60, 60, 60};
  const auto steps = FitLocalSteps(z, options);
  ASSERT_EQ(steps.size(), 342U);
  int compared = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].evidence <= 0.0) continue;
    EXPECT_NEAR(steps[i].height_m, HeightByQr(z, 3 * static_cast<int>(i), 60), 2e-9) << i;
    ++compared;
  }
  EXPECT_GT(compared, 20);
}

TEST(LocalStep, TheStepStandsOutWhereItIs) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Rng rng(seed);
    const int edge = 100 + static_cast<int>(rng.Index(800));
    std::vector<float> z;
    for (int i = 0; i < 1024; ++i) {
      const double height = 0.02 * i / 12e3 + (i >= edge ? 0.5e-3 : 0.0) + 0.05e-3 * rng.Normal();
      z.push_back(rng.Uniform() < 0.2 ? kNone : static_cast<float>(height));
    }
    const auto steps = FitLocalSteps(z);
    const std::size_t best = StrongestOf(steps);
    EXPECT_NEAR(3.0 * static_cast<double>(best), edge, 6.0) << seed;
    EXPECT_NEAR(steps[best].height_m, 0.5e-3, 0.06e-3) << seed;
  }
}

TEST(LocalStep, FallingHighOrNoStepsAreNone) {
  std::vector<float> falling, high, flat, nothing(1024, kNone);
  for (int i = 0; i < 1024; ++i) {
    falling.push_back(i < 500 ? 0.5e-3F : 0.0F);
    high.push_back(i < 500 ? 0.0F : 3.2e-3F);
    flat.push_back(0.001F);
  }
  for (const auto& z : {falling, high, flat, nothing}) {
    const auto steps = FitLocalSteps(z);
    ASSERT_EQ(steps.size(), 342U);
    // About 500 neither is a step that rises by up to 2.5 mm.
    for (std::size_t i = 150; i < 185; ++i) EXPECT_LT(steps[i].height_m, 2.5e-3) << i;
    EXPECT_EQ(steps[500 / 3].evidence, 0.0);
  }
}

// On a mould light comes back from 20 mm only, so that a wide window at any place holds the edge.
TEST(LocalStep, AnEdgeInAllWindowsIsNoNoise) {
  constexpr int kStepColumns = 260;
  double log_ratio = 0.0;
  constexpr int kStepSeeds = 100;
  for (std::uint64_t seed = 0; seed < kStepSeeds; ++seed) {
    Rng rng(seed);
    std::vector<float> flat(1024, kNone);
    // Residuals of a surface: each is like its neighbors.
    double residual = 0.0;
    for (int i = 0; i < kStepColumns; ++i) {
      residual = 0.8 * residual + 0.6 * rng.Normal();
      flat[static_cast<std::size_t>(400 + i)] = static_cast<float>(0.1e-3 * residual);
    }
    auto stepped = flat;
    for (std::size_t i = 400 + kStepColumns / 2; i < 1024; ++i) stepped[i] += 0.3e-3F;
    const std::size_t edge = (400 + kStepColumns / 2) / 3;
    log_ratio += std::log(FitLocalSteps(stepped)[edge].surest_precision_m2 /
                          FitLocalSteps(flat)[edge].surest_precision_m2);
  }
  // How well the height of a step is known hangs on the residuals, not on the step. Profiles beyond
  // doubt keep what the step makes worse, so that the mean is not quite 0.
  EXPECT_NEAR(log_ratio / kStepSeeds, 0.0, std::log(1.5));
}

TEST(LocalStep, EvidenceDoesNotGrowWithTheNoise) {
  // What noise alone brings about is the same whether it is low or high.
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    std::array<std::vector<LocalStep>, 2> steps;
    for (const int way : {0, 1}) {
      Rng rng(seed);
      std::vector<float> z;
      for (int i = 0; i < 1024; ++i) {
        z.push_back(static_cast<float>((way == 0 ? 0.1e-3 : 0.4e-3) * rng.Normal()));
      }
      steps[static_cast<std::size_t>(way)] = FitLocalSteps(z);
    }
    const double low = steps[0][StrongestOf(steps[0])].evidence;
    EXPECT_NEAR(steps[1][StrongestOf(steps[1])].evidence, low, 0.1 * low) << seed;
    EXPECT_LT(low, 20.0) << seed;
  }
}

TEST(LocalStep, ShortProfilesAndImpossibleOptions) {
  EXPECT_TRUE(FitLocalSteps({}).empty());
  EXPECT_EQ(FitLocalSteps(std::vector<float>(5, 0.0F)).size(), 2U);
  LocalStepOptions options;
  options.stride = 0;
  EXPECT_THROW(FitLocalSteps(std::vector<float>(64, 0.0F), options), std::invalid_argument);
  options.stride = 3;
  options.half_windows = {30, 2, 60, 90};
  EXPECT_THROW(FitLocalSteps(std::vector<float>(64, 0.0F), options), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::seam
