#pragma once

#include "robot/hand_model.h"
#include "robot/internal/mjcf.h"

namespace rangegrasp::robot::internal {

/// Closes the hand below `hand_body` step by step and records what the caliper looks like. Driven
/// joints keep the MJCF's joint equalities; passive ones stand where their springs pull them when
/// nothing touches them. Changes mjcf's joint positions.
HandModel SampleHand(const Mjcf& mjcf, int hand_body);

}  // namespace rangegrasp::robot::internal
