#pragma once

#include <string>

#include "base/rng.h"
#include "base/units.h"
#include "base/yaml_map.h"
#include "sim/execute.h"
#include "trial/attempt.h"

namespace rangegrasp::trial {

/// The outcome of a run whose object a person has got.
inline constexpr const char* kHandedOver = "handed_over";

/// A person who draws the object out of the hand (section 4.3).
struct HandOverOptions {
  sim::UserOptions user;
  /// The pull's direction is drawn within this of the one that objects leave the open hand by:
  /// people stand somewhere. Larger: the object is drawn through fingers.
  double pull_spread_rad = base::Deg(30.0);
};

/// Reads the keys of the mapping `user`. @throws base::InputError
void ReadUser(base::YamlMap map, HandOverOptions& options);

/// The person of one run.
/// @param out_H  unit: out of the open hand
sim::UserOptions UserFor(const HandOverOptions& options, const Eigen::Vector3d& out_H,
                         base::Rng& rng);

/// That of an attempt with the robot's hand, drawn from the stream "user" of the attempt's seed.
sim::UserOptions UserOf(const HandOverOptions& options, const robot::Robot& robot,
                        std::uint64_t seed);

/// How an attempt that ends with a person ended: its own word up to the carry; then handed_over,
/// felt_early (the arm took its own motion for a pull), not_felt, not_taken.
std::string HandOverOutcome(const Attempt& attempt);

}  // namespace rangegrasp::trial
