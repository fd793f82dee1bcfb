#pragma once

#include <deque>

#include "base/rng.h"
#include "sim/execute.h"

namespace rangegrasp::sim::internal {

/// What the distal pads' sensors hear: the speed at which something slides along a pad, read with
/// noise at a fixed period whatever the time step is, and told when the delay has passed.
class SlipSensor {
 public:
  SlipSensor(const HandControlOptions& options, base::Rng rng) : options_(options), rng_(rng) {}

  /// Once a time step. @param speed_m_s  of the fastest contact with a pad; 0 where none slides
  /// @return whether the newest reading that has come through tells of a slip.
  bool Tick(double time_s, double speed_m_s);

 private:
  struct Reading {
    double time_s;
    bool slips;
  };

  HandControlOptions options_;
  base::Rng rng_;
  std::deque<Reading> underway_;
  double next_s_ = 0.0;
  bool heard_ = false;
};

}  // namespace rangegrasp::sim::internal
