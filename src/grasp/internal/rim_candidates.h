#pragma once

#include <vector>

#include "grasp/internal/placing.h"

namespace rangegrasp::grasp::internal {

/// The wall of an open rotational object between the pads, or, where the top is closed, the tips on
/// two opposite points of its rim; none without an upright rotation axis.
std::vector<Candidate> RimCandidates(Task& task);

}  // namespace rangegrasp::grasp::internal
