#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cylinders/demo/demo_detector.h"
#include "cylinders/demo/demo_options.h"
#include "trial/attempt.h"

namespace rangegrasp::demo {

/// What a replay looks at; each may be empty.
struct Viewers {
  sim::ExecutionObserver execution;
  CylinderObserver cylinders;
  std::function<void(int)> on_try;  ///< 1 and up, before it
};

/// A detected cylinder beside the true one.
struct FoundError {
  bool lies = false;      ///< FoundCylinder's
  bool from_rim = false;  ///< likewise
  double length_seen_m = 0.0;
  double axis_rad = 0.0;  ///< between the axes
  double along_m = 0.0;   ///< of the centre of gravity, along the true axis
  double across_m = 0.0;  ///< of the same, square to it
};

/// A look at the table, and a grasp if the wanted cylinder is found.
struct Try {
  trial::Attempt attempt;
  std::string outcome;
  std::optional<FoundError> found;  ///< of the wanted one
};

/// Whether the robot knows, by its own sensors, that there is something to be tried again: nothing
/// was found, planned, or held, and nobody has been offered anything.
bool KnowsItFailed(const trial::Attempt& attempt, Delivery delivery);

/// A run on a table that is laid: tries, at most options.demo.max_tries, until the robot takes the
/// wanted cylinder for delivered. Before each further one the arm goes home, and the table is
/// scanned again. The robot goes by its detection and the hand's joints; truth names the outcomes
/// alone. Each try draws from its own streams of the seed.
/// @param wanted  position in options.demo.given
/// @param target  truth: that object in the world
/// @return at least one
std::vector<Try> RunDemo(const Options& options, const trial::Cell& cell, std::size_t wanted,
                         int target, std::uint64_t seed, sim::World& world, const Viewers& viewers);

}  // namespace rangegrasp::demo
