#pragma once

#include <optional>
#include <vector>

#include "robot/mjcf/hand.h"
#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {

/// Open and closed lengths for the drives of fingers with several joints each. In the closed hand
/// the fingertips stand in a row, and the thumb's tip meets their middle. In the open one they
/// stand apart, on a line across the row that the way between both follows, and the last segments
/// stand square to it. By kinematics alone; joints stay near the middle of their ranges, the
/// outermost ones near straight. The thumb stands on the side of the row on which that takes less.
/// @param fingertips  geoms, the thumb's first
/// @return nullopt unless there are more drives than fingers, each on a joint of its own, and no
/// other joint in the hand
std::optional<std::vector<mjcf::HandMotor>> FingerPoses(const Model& model,
                                                        const std::vector<int>& actuators,
                                                        const std::vector<int>& fingertips);

}  // namespace rangegrasp::check::internal
