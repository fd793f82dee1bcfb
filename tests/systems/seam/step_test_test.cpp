#include "seam/step_test.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"

namespace rangegrasp::seam {
namespace {

using base::Rng;

constexpr double kStepTestSigma_m = 0.1e-3;

// A bent and tilted surface with a step.
PreparedProfile StepTestScan(double step_m, double edge_column, double sigma_m, double time_s,
                             Rng& rng) {
  PreparedProfile profile;
  profile.time_s = time_s;
  profile.last_column = 1023;
  for (int i = 0; i < 1024; ++i) {
    const double u = i / 512.0 - 1.0;
    const double z = 2e-3 * u + 3e-3 * u * u + (i >= edge_column ? step_m : 0.0);
    profile.height_m.push_back(static_cast<float>(z + sigma_m * rng.Normal()));
  }
  return profile;
}

TEST(StepTest, MeasuresAStepOnABentSurfaceAndFindsIt) {
  Rng rng(1);
  for (const double step : {0.3e-3, 1.1e-3}) {
    StepTest test({});
    test.Take(StepTestScan(step, 480.0, 0.0, 0.0, rng));
    EXPECT_NEAR(test.HeightAt(480.0).value(), step, 1e-8);
    EXPECT_NEAR(test.HeightAt(200.0).value(), 0.0, 1e-8);
    EXPECT_NEAR(test.Locate(470.0, 24.0).value(), 480.0, 1.0);
  }
}

// A median of 6 columns of noise has at most sqrt(pi/2/6) of its deviation; the kernel of 19 + 19
// blocks multiplies it by 0.72 and five profiles divide it by sqrt(5): 0.017 mm. Five times that.
TEST(StepTest, AveragesTheNoiseOfAPeriodAway) {
  constexpr double kTolerance_m = 5.0 * 0.017e-3;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Rng rng(seed);
    StepTest test({});
    for (int i = 0; i < 5; ++i)
      test.Take(StepTestScan(0.3e-3, 480.0, kStepTestSigma_m, 0.02 * i, rng));
    EXPECT_NEAR(test.HeightAt(480.0).value(), 0.3e-3, kTolerance_m) << seed;
    EXPECT_LT(test.HeightAt(200.0).value(), kTolerance_m) << seed;
  }
}

TEST(StepTest, ForgetsWhatIsOlderThanAPeriodButForThreeProfiles) {
  Rng rng(2);
  StepTest test({});
  for (int i = 0; i < 8; ++i) test.Take(StepTestScan(0.8e-3, 480.0, 0.0, 0.01 * i, rng));
  for (int i = 0; i < 3; ++i) test.Take(StepTestScan(0.0, 480.0, 0.0, 1.0 + 0.1 * i, rng));
  EXPECT_NEAR(test.HeightAt(480.0).value(), 0.0, 1e-8);
}

TEST(StepTest, TellsNothingNearTheEndsOfWhatWasMeasured) {
  Rng rng(3);
  StepTest test({});
  EXPECT_FALSE(test.HeightAt(480.0));
  auto profile = StepTestScan(0.5e-3, 480.0, 0.0, 0.0, rng);
  profile.first_column = 470;
  test.Take(profile);
  EXPECT_FALSE(test.HeightAt(480.0));
  EXPECT_TRUE(test.HeightAt(520.0));
}

}  // namespace
}  // namespace rangegrasp::seam
