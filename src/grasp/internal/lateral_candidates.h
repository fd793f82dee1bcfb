#pragma once

#include <vector>

#include "grasp/internal/placing.h"

namespace rangegrasp::grasp::internal {

/// Power grasps from the side, thumb and fingers left and right of the object: what section 7.2
/// wants for a tall one, such as an aerosol can.
std::vector<Candidate> LateralCandidates(Task& task);

}  // namespace rangegrasp::grasp::internal
