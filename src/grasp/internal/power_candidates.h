#pragma once

#include <vector>

#include "grasp/internal/placing.h"

namespace rangegrasp::grasp::internal {

/// From above.
std::vector<Candidate> PowerCandidates(Task& task);

/// Power grasps from all round and no deeper than the centre of mass: for objects between others,
/// where none of the better ones is free.
std::vector<Candidate> CrowdedCandidates(Task& task);

}  // namespace rangegrasp::grasp::internal
