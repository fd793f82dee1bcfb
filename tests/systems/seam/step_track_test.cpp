#include "seam/step_track.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "base/rng.h"
#include "base/units.h"

namespace rangegrasp::seam {
namespace {

using base::Rng;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

std::size_t StrongestOf(const std::vector<LocalStep>& steps) {
  const auto best = std::ranges::max_element(steps, {}, &LocalStep::evidence);
  return static_cast<std::size_t>(best - steps.begin());
}

// A rising cubic with a step. Medians leave it unchanged.
std::vector<float> RisingCubic(int columns, int edge, double step_m) {
  std::vector<float> z;
  for (int i = 0; i < columns; ++i) {
    const double u = i / 300.0;
    z.push_back(static_cast<float>(1e-3 * (u + 0.2 * u * u * u) + (i >= edge ? step_m : 0.0)));
  }
  return z;
}

// Solves the same least-squares problem by a QR decomposition.
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
    // Around column 500, neither `falling` nor `high` has a step that rises by up to 2.5 mm.
    for (std::size_t i = 150; i < 185; ++i) EXPECT_LT(steps[i].height_m, 2.5e-3) << i;
    EXPECT_EQ(steps[500 / 3].evidence, 0.0);
  }
}

// On a mould only 20 mm of the line return light, so a wide window contains the edge at any place.
TEST(LocalStep, AnEdgeInAllWindowsIsNoNoise) {
  constexpr int kStepColumns = 260;
  double log_ratio = 0.0;
  constexpr int kStepSeeds = 100;
  for (std::uint64_t seed = 0; seed < kStepSeeds; ++seed) {
    Rng rng(seed);
    std::vector<float> flat(1024, kNone);
    // The residuals of a surface are correlated with their neighbors.
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
  // The precision of a step's height depends on the residuals, not on the step. Profiles beyond
  // doubt keep what the step makes worse, so that the mean is not quite 0.
  EXPECT_NEAR(log_ratio / kStepSeeds, 0.0, std::log(1.5));
}

TEST(LocalStep, EvidenceDoesNotGrowWithTheNoise) {
  // The evidence from noise alone is the same for low and high noise.
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

TEST(LocalStep, ShortProfilesHaveFewPlaces) {
  EXPECT_TRUE(FitLocalSteps({}).empty());
  EXPECT_EQ(FitLocalSteps(std::vector<float>(5, 0.0F)).size(), 2U);
}

constexpr double kPeriod_s = 1.0 / 62.0;
constexpr int kStepTrackColumns = 1024;
constexpr double kColumns_1_mm = 12.0;

// The surface along a line over two mats, heights in millimetres.
struct Surface {
  const char* name;
  double step = 0.6;
  double slant = 0.1;
  double noise = 0.05;
  double lost = 0.02;
  double wave = 0.0;     // amplitude; wavelength 10 to 40 mm
  double wanted = 0.98;  // share within a millimetre
};

struct Seam {
  double edge, speed, tilt, bend, length, length_ahead, phase;
  explicit Seam(Rng& rng)
      : edge(rng.Uniform(200.0, 824.0)),
        speed(rng.Uniform(-30.0, 30.0)),
        tilt(rng.Uniform(-0.05, 0.05)),
        bend(rng.Uniform(-0.5, 0.5)),
        length(rng.Uniform(10.0, 40.0)),
        length_ahead(rng.Uniform(10.0, 40.0)),
        phase(rng.Uniform(0.0, 2.0 * base::kPi)) {}
  double EdgeAt(double t) const { return edge + speed * t; }
};

std::vector<float> StepTrackScan(const Surface& surface, const Seam& seam, double t, Rng& rng) {
  std::vector<float> z;
  for (int i = 0; i < kStepTrackColumns; ++i) {
    const double x = (i - 0.5 * (kStepTrackColumns - 1)) / kColumns_1_mm;
    const double rise = (i - seam.EdgeAt(t)) / kColumns_1_mm / surface.slant + 0.5;
    double height = seam.tilt * x + seam.bend * (x / 42.0) * (x / 42.0);
    height += surface.step * std::clamp(rise, 0.0, 1.0);
    height +=
        surface.wave *
        std::sin(2.0 * base::kPi * (x / seam.length + 30.0 * t / seam.length_ahead) + seam.phase);
    height += surface.noise * rng.Normal();
    z.push_back(rng.Uniform() < surface.lost ? kNone : static_cast<float>(1e-3 * height));
  }
  return z;
}

// The estimates of a track for each profile of a seam. Profile k shows `mats_at(k)`.
std::vector<StepTrack::Estimate> Tracked(const Seam& seam, int profiles,
                                         const std::function<Surface(int)>& mats_at, Rng& rng) {
  StepTrack track({});
  std::vector<StepTrack::Estimate> found;
  for (int k = 0; k < profiles; ++k) {
    const double t = k * kPeriod_s;
    found.push_back(track.Update(StepTrackScan(mats_at(k), seam, t, rng), t));
  }
  return found;
}

// The same for a random seam.
std::vector<StepTrack::Estimate> Tracked(std::uint64_t seed, int profiles,
                                         const std::function<Surface(int)>& mats_at) {
  Rng rng(seed);
  const Seam seam(rng);
  return Tracked(seam, profiles, mats_at, rng);
}

struct Score {
  int profiles = 0, within = 0, edges = 0;
};

Score ScoreOn(const Surface& surface, int seams, int profiles) {
  Score score;
  for (int number = 0; number < seams; ++number) {
    Rng rng(base::DeriveSeed(static_cast<std::uint64_t>(number), surface.name));
    const Seam seam(rng);
    const auto mats_at = [&](int) { return surface; };
    const auto found = Tracked(seam, profiles, mats_at, rng);
    for (int k = 0; k < profiles; ++k) {
      const auto& column = found[static_cast<std::size_t>(k)].column;
      ++score.profiles;
      score.edges += column ? 1 : 0;
      score.within += column && std::abs(*column - seam.EdgeAt(k * kPeriod_s)) <= kColumns_1_mm;
    }
  }
  return score;
}

class StepTrackEdges : public testing::TestWithParam<Surface> {};
INSTANTIATE_TEST_SUITE_P(Surfaces, StepTrackEdges,
                         testing::Values(Surface{.name = "slant", .slant = 2.0},
                                         Surface{.name = "low_slant", .step = 0.3, .slant = 2.0},
                                         Surface{.name = "low_step", .step = 0.25},
                                         Surface{.name = "noise", .noise = 0.4},
                                         Surface{.name = "holes", .lost = 0.9},
                                         Surface{.name = "waves", .wave = 0.3, .wanted = 0.9}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(StepTrackEdges, AreFoundWithinAMillimetre) {
  const Score score = ScoreOn(GetParam(), 12, 60);
  EXPECT_GE(score.within, GetParam().wanted * score.profiles);
}

class NoEdges : public testing::TestWithParam<Surface> {};
INSTANTIATE_TEST_SUITE_P(Surfaces, NoEdges,
                         testing::Values(Surface{.name = "flat", .step = 0.0},
                                         Surface{.name = "noise", .step = 0.0, .noise = 0.4},
                                         Surface{.name = "holes", .step = 0.0, .lost = 0.9},
                                         Surface{.name = "waves", .step = 0.0, .wave = 0.3}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(NoEdges, AreToldToBeNone) {
  const Score score = ScoreOn(GetParam(), 40, 60);
  EXPECT_LE(score.edges, 0.005 * score.profiles);
}

TEST(StepTrack, FollowsAnEdgeThatMovesAsFastAsAHeadMayTurn) {
  Rng rng(5);
  Seam seam(rng);
  seam.edge = 200.0;
  seam.speed = 480.0;  // 40 mm/s
  const auto mats_at = [](int) { return Surface{.name = ""}; };
  const auto found = Tracked(seam, 70, mats_at, rng);
  for (std::size_t k = 0; k < found.size(); ++k) {
    ASSERT_TRUE(found[k].column) << k;
    EXPECT_NEAR(*found[k].column, seam.EdgeAt(static_cast<double>(k) * kPeriod_s), 6.0) << k;
    EXPECT_NEAR(found[k].step_m, 0.6e-3, 0.1e-3) << k;
  }
}

// Each profile without the step removes nearly as much evidence as one with the step added. The
// track remembers about the last ten profiles, so the edge ends after some six profiles.
TEST(StepTrack, AnEdgeThatEndsGoesOnForTenProfilesAtMost) {
  for (const double noise : {0.05, 0.2}) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const auto found = Tracked(seed, 60, [&](int k) {
        return Surface{.name = "", .step = k < 30 ? 0.6 : 0.0, .noise = noise};
      });
      for (std::size_t k = 5; k < 30; ++k) EXPECT_TRUE(found[k].goes_on) << seed << ", " << k;
      for (std::size_t k = 40; k < 60; ++k) EXPECT_FALSE(found[k].goes_on) << seed << ", " << k;
    }
  }
}

TEST(StepTrack, AnEdgeIsSureOnceTenProfilesWereAndNoLongerSoonAfterItsEnd) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto found = Tracked(seed, 70, [](int k) {
      return Surface{.name = "", .step = k < 30 ? 0.6 : 0.0, .noise = 0.2};
    });
    for (std::size_t k = 0; k < 9; ++k) EXPECT_FALSE(found[k].sure) << seed << ", " << k;
    for (std::size_t k = 15; k < 30; ++k) EXPECT_TRUE(found[k].sure) << seed << ", " << k;
    for (std::size_t k = 35; k < 70; ++k) EXPECT_FALSE(found[k].sure) << seed << ", " << k;
  }
}

// The evidence of low edges varies around the threshold, while each profile shows them at the same
// place.
TEST(StepTrack, AnEdgeThatOnlyJustSufficesIsSureTimeAndAgainAndNotAfterItsEnd) {
  constexpr int kFrom = 30, kEnd = 150;
  // A line 80 mm ahead takes at least this many profiles before the head reaches the place where
  // the edge was sure.
  constexpr int kLong = 60;
  for (const Surface& mats : {Surface{.name = "", .step = 0.3, .noise = 0.6, .lost = 0.3},
                              Surface{.name = "", .step = 0.4, .noise = 0.8, .lost = 0.3}}) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const auto found = Tracked(seed, kEnd + 40, [&](int k) {
        Surface here = mats;
        if (k >= kEnd) here.step = 0.0;
        return here;
      });
      int unsure = 0;
      for (std::size_t k = 0; k < kEnd; ++k) {
        unsure = found[k].sure ? 0 : unsure + 1;
        EXPECT_TRUE(k < kFrom || unsure < kLong) << seed << ", " << k;
      }
      for (std::size_t k = kEnd + 10; k < found.size(); ++k) {
        EXPECT_FALSE(found[k].sure) << seed << ", " << k;
      }
    }
  }
}

// Something that looks like the edge some time after its end may be a mould's flank.
TEST(StepTrack, AnEdgeThatWasGoneTakesLongerToBeSureAgain) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto found = Tracked(seed, 90, [](int k) {
      return Surface{.name = "", .step = k < 20 || k >= 50 ? 0.6 : 0.0, .noise = 0.2};
    });
    for (std::size_t k = 12; k < 20; ++k) EXPECT_TRUE(found[k].sure) << seed << ", " << k;
    // The first seven profiles that show the edge again only restore the odds.
    for (std::size_t k = 30; k < 50 + 7 + 13; ++k) EXPECT_FALSE(found[k].sure) << seed << ", " << k;
    for (std::size_t k = 80; k < 90; ++k) EXPECT_TRUE(found[k].sure) << seed << ", " << k;
  }
}

// Noise elsewhere gives enough evidence for an edge to continue, and steps as high as this one.
TEST(StepTrack, NoiseDoesNotTakeOverAnEdgeThatEnds) {
  int before = 0, after = 0;
  constexpr int kSeams = 20, kBefore = 40, kAfter = 40, kTold = 12;
  for (std::uint64_t seed = 0; seed < kSeams; ++seed) {
    const auto found = Tracked(seed, kBefore + kAfter, [](int k) {
      return Surface{.name = "", .step = k < kBefore ? 0.5 : 0.0, .noise = 0.4, .lost = 0.5};
    });
    for (std::size_t k = kTold; k < kBefore; ++k) before += found[k].goes_on;
    for (std::size_t k = kBefore + kTold; k < kBefore + kAfter; ++k) after += found[k].goes_on;
  }
  EXPECT_GE(before, 0.97 * kSeams * (kBefore - kTold));
  EXPECT_LE(after, 0.02 * kSeams * (kAfter - kTold));
}

// The line moves faster than an edge may move by itself.
TEST(StepTrack, ALineThatMovesKeepsItsEdge) {
  Rng rng(8);
  Seam seam(rng);
  seam.edge = 824.0;
  seam.speed = -900.0;  // 75 mm/s
  StepTrack told({}), untold({});
  int kept = 0;
  for (int k = 0; k < 40; ++k) {
    const double t = k * kPeriod_s;
    const auto z = StepTrackScan({.name = "", .noise = 0.2}, seam, t, rng);
    const auto found = told.Update(z, t, k > 0 ? -seam.speed * kPeriod_s : 0.0);
    kept += untold.Update(z, t).goes_on;
    ASSERT_TRUE(found.column) << k;
    EXPECT_NEAR(*found.column, seam.EdgeAt(t), 8.0) << k;
    EXPECT_TRUE(k < 2 || found.goes_on) << k;
  }
  EXPECT_LT(kept, 20);
}

// A single profile may show something else. A jump counts once a second profile shows it, too.
TEST(StepTrack, AnEdgeThatJumpsIsToldAtOnce) {
  Rng rng(9);
  Seam seam(rng);
  seam.edge = 300.0;
  seam.speed = 0.0;
  StepTrack track({});
  for (int k = 0; k < 34; ++k) {
    if (k == 30) seam.edge = 430.0;  // 11 mm
    const auto found =
        track.Update(StepTrackScan({.name = ""}, seam, k * kPeriod_s, rng), k * kPeriod_s);
    if (k == 30) {
      EXPECT_FALSE(found.at_once);
    } else if (k >= 2) {
      ASSERT_TRUE(found.at_once) << k;
      EXPECT_NEAR(*found.at_once, seam.edge, 6.0) << k;
    }
    if (k == 31) {
      EXPECT_NEAR(*found.column, 300.0, 6.0);
    }
  }
}

TEST(StepTrack, AStepThatIsTooLowIsNoEdge) {
  StepTrackOptions options;
  options.min_step_m = 0.8e-3;
  StepTrack track(options);
  Rng rng(6);
  const Seam seam(rng);
  for (int k = 0; k < 20; ++k) {
    const auto found =
        track.Update(StepTrackScan({.name = ""}, seam, k * kPeriod_s, rng), k * kPeriod_s);
    EXPECT_FALSE(found.column);
    EXPECT_TRUE(found.strongest);
  }
}

TEST(StepTrack, AfterALongGapNothingIsKnown) {
  Rng rng(7);
  const Seam seam(rng);
  const Surface noisy{.name = "", .noise = 0.4};
  StepTrack once({});
  StepTrack twice({});
  for (int k = 0; k < 5; ++k)
    twice.Update(StepTrackScan(noisy, seam, k * kPeriod_s, rng), k * kPeriod_s);
  const auto z = StepTrackScan(noisy, seam, 9.0, rng);
  EXPECT_EQ(once.Update(z, 9.0).step_m, twice.Update(z, 9.0).step_m);
}

}  // namespace
}  // namespace rangegrasp::seam
