#pragma once

#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {

/// Of a hand whose one geared motor closes its hinges ("hand_joints"): ranges, and what they move.
void CheckGearedHand(Model& model);

}  // namespace rangegrasp::check::internal
