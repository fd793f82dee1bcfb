#include "sim/read_options.h"

#include <fmt/format.h>

#include "base/units.h"

namespace rangegrasp::sim {

using base::kDeg;
using base::kMm;
using base::YamlMap;

void ReadPhysicsOptions(YamlMap map, PhysicsOptions& options) {
  map.ReadScaled("timestep_ms", options.timestep_s, kMm, 0.1, 4.0, "time step of the engine");
  map.Read(
      "friction", options.friction,
      "of the glove on each object: drawn from its range in each trial; the middle, the low or "
      "the high end; or the kinetic coefficient in place of the static one");
  map.Read("glove_friction", options.glove_friction, 0.0, 2.0,
           "one coefficient for the glove on everything, in place of the table of pairs");
  map.Finish();
}

void ReadHandOptions(YamlMap map, double& firm_from_rad, HandControlOptions& options) {
  map.Read("initial_force_n", options.initial_force_N, 5.0, 100.0,
           "first grip at the finger tips; without it the hand's own");
  map.Read("max_force_n", options.max_force_N, 5.0, 100.0, "strongest grip; likewise");
  map.ReadScaled("firm_from_deg", firm_from_rad, kDeg, 0.0, 90.0,
                 "faces that lean by more than this are gripped with the strongest force at once");
  map.Read("slip_control", options.slip_control, "grips harder while the load slips");
  map.ReadScaled("slip_threshold_mm_s", options.slip_threshold_m_s, kMm, 0.1, 1000.0,
                 "slower sliding along the distal pads is not heard");
  map.ReadScaled("slip_delay_ms", options.slip_delay_s, 1e-3, 0.0, 1000.0,
                 "from a slide to the controller");
  map.ReadScaled("slip_noise_mm_s", options.slip_noise_m_s, kMm, 0.0, 1000.0,
                 "standard deviation of what is heard");
  if (options.initial_force_N && options.max_force_N &&
      *options.initial_force_N > *options.max_force_N) {
    map.Fail(map.Has("max_force_n") ? "max_force_n" : "initial_force_n",
             fmt::format("the first grip ({:g} N) must not be stronger than the strongest ({:g} N)",
                         *options.initial_force_N, *options.max_force_N));
  }
  map.Finish();
}

}  // namespace rangegrasp::sim
