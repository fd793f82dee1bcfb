#pragma once

#include <vector>

#include "grasp/internal/placing.h"

namespace rangegrasp::grasp::internal {

/// Round an upright rotation axis, from all sides; none where the object is too wide.
std::vector<Candidate> CylindricalCandidates(Task& task);

}  // namespace rangegrasp::grasp::internal
