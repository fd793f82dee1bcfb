#pragma once

#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {

void CheckArm(Model& model);     ///< chain, ranges, drives, armature, gravity compensation
void CheckMotion(Model& model);  ///< reach, strength, the home pose held, a motion followed

}  // namespace rangegrasp::check::internal
