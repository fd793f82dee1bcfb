#pragma once

#include <optional>
#include <vector>

#include "robot/mjcf/hand.h"
#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {

/// Open and closed lengths for the drives of fingers with several joints each, by kinematics alone.
/// In the closed hand the fingertips are in a row, and the thumb's tip meets the row's middle. In
/// the open hand the tips are apart along a line across the row, which they also follow in between,
/// and the last segments are perpendicular to it. Joints stay near the middle of their ranges, the
/// outermost ones nearly straight. The thumb is on the side of the row where this costs less.
/// @param fingertips  geoms, the thumb's first
/// @return nullopt unless there are more drives than fingers, each on its own joint, and the hand
/// has no other joint
std::optional<std::vector<mjcf::HandMotor>> FingerPoses(const Model& model,
                                                        const std::vector<int>& actuators,
                                                        const std::vector<int>& fingertips);

}  // namespace rangegrasp::check::internal
