#pragma once

#include <optional>
#include <vector>

#include "robot/mjcf/hand.h"
#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {

/// Open and closed lengths for the drives of fingers with several joints each: the thumb's tip and
/// the middle of the other fingertips meet in the closed hand, and stand apart in the open one, on
/// a line across the row of fingers that the way between both follows. By kinematics alone; joints
/// stay near the middle of their ranges, the outermost ones near straight.
/// @param fingertips  geoms, the thumb's first
/// @return nullopt unless there are more drives than fingers, each on a joint of its own, and no
/// other joint in the hand
std::optional<std::vector<mjcf::HandMotor>> FingerPoses(const Model& model,
                                                        const std::vector<int>& actuators,
                                                        const std::vector<int>& fingertips);

}  // namespace rangegrasp::check::internal
