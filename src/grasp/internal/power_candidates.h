#pragma once

#include <vector>

#include "grasp/internal/placing.h"

namespace rangegrasp::grasp::internal {

/// From above, with or without refinement (GraspOptions::refine).
std::vector<Candidate> PowerCandidates(Task& task);

}  // namespace rangegrasp::grasp::internal
