#pragma once

#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {

/// Checks a hand with one geared motor on its hinges ("hand_joints"): ranges, and what they move.
void CheckGearedHand(Model& model);

}  // namespace rangegrasp::check::internal
