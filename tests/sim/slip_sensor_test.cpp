#include "sim/internal/slip_sensor.h"

#include <gtest/gtest.h>

namespace rangegrasp::sim::internal {
namespace {

HandControlOptions Quiet() {
  HandControlOptions options;
  options.slip_noise_m_s = 0.0;
  return options;
}

// When a slide at a speed that begins at 0.1 s is heard first; 0 if it never is within a second.
double HeardAt(const HandControlOptions& options, double speed_m_s, double step_s) {
  SlipSensor sensor(options, base::Rng(3));
  for (int i = 0; i * step_s < 1.0; ++i) {
    const double time_s = i * step_s;
    if (sensor.Tick(time_s, time_s >= 0.1 ? speed_m_s : 0.0)) return time_s;
  }
  return 0.0;
}

// A reading is due each 8 ms and comes through 20 ms later, whatever the time step is.
TEST(SlipSensor, HearsWhatIsAboveTheThresholdAfterTheDelay) {
  for (const double step_s : {0.004, 0.002, 0.001}) {
    EXPECT_GE(HeardAt(Quiet(), 0.0021, step_s), 0.1 + 0.020) << step_s;
    EXPECT_LE(HeardAt(Quiet(), 0.0021, step_s), 0.1 + 0.020 + 0.008 + 1e-9) << step_s;
    EXPECT_EQ(HeardAt(Quiet(), 0.0019, step_s), 0.0) << step_s;
  }
}

TEST(SlipSensor, IsSilentAgainAfterTheSlide) {
  SlipSensor sensor(Quiet(), base::Rng(3));
  bool heard = false;
  for (int i = 0; i < 100; ++i) heard = sensor.Tick(0.002 * i, i < 50 ? 0.01 : 0.0);
  EXPECT_FALSE(heard);
}

// Readings above the threshold of a slide just at it: half. Of none: a normal reading 5 deviations
// off, once in 3.5 million.
TEST(SlipSensor, NoiseIsOfEachReading) {
  HandControlOptions options;
  options.slip_delay_s = 0.0;
  SlipSensor at_threshold(options, base::Rng(3));
  SlipSensor still(options, base::Rng(4));
  int heard = 0;
  int false_alarms = 0;
  for (int i = 0; i < 4000; ++i) {
    heard += at_threshold.Tick(0.008 * i, options.slip_threshold_m_s) ? 1 : 0;
    false_alarms += still.Tick(0.008 * i, 0.0) ? 1 : 0;
  }
  EXPECT_NEAR(heard, 2000, 4 * 32);  // four standard deviations of a binomial
  EXPECT_EQ(false_alarms, 0);
}

}  // namespace
}  // namespace rangegrasp::sim::internal
