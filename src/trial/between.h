#pragma once

#include "trial/attempt.h"

namespace rangegrasp::trial {

/// Between two attempts the arm stands at home again: its way there is timed, not simulated; then
/// the world comes to rest. @return seconds that the way takes by the arm's limits
double GoHome(const Cell& cell, sim::World& world);

/// Whether the engine still knows where everything is.
bool IsFinite(const sim::World& world);

}  // namespace rangegrasp::trial
