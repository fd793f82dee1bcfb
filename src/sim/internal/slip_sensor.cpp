#include "sim/internal/slip_sensor.h"

namespace rangegrasp::sim::internal {
namespace {

// Of the readings: 5 of them in the time after which a force may be raised again.
constexpr double kPeriod_s = 0.008;
// A time step may end a rounding error before a reading is due.
constexpr double kRounding_s = 1e-9;

}  // namespace

bool SlipSensor::Tick(double time_s, double speed_m_s) {
  if (time_s + kRounding_s >= next_s_) {
    const double noisy_m_s = speed_m_s + options_.slip_noise_m_s * rng_.Normal();
    underway_.push_back({time_s, noisy_m_s > options_.slip_threshold_m_s});
    next_s_ = time_s + kPeriod_s;
  }
  while (!underway_.empty() &&
         underway_.front().time_s + options_.slip_delay_s <= time_s + kRounding_s) {
    heard_ = underway_.front().slips;
    underway_.pop_front();
  }
  return heard_;
}

}  // namespace rangegrasp::sim::internal
