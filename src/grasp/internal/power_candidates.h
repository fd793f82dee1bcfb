#pragma once

#include <vector>

#include "grasp/internal/placing.h"

namespace rangegrasp::grasp::internal {

/// From above.
std::vector<Candidate> PowerCandidates(Task& task);

/// Power grasps closing from all round, no deeper than the centre of mass, by an upper part where
/// the object is too wide: for objects between others, where few of the better ones are free.
/// @param round  0: from above; k: leaning by PowerOptions::crowded_leans_rad[k - 1]
std::vector<Candidate> CrowdedCandidates(Task& task, std::size_t round);

}  // namespace rangegrasp::grasp::internal
