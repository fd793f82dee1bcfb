#pragma once

#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {

void CheckArm(Model& model);  ///< checks chain, ranges, drives, armature, gravity compensation

}  // namespace rangegrasp::check::internal
