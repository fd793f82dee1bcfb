#pragma once

#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {

void CheckArm(Model& model);  ///< checks chain, ranges, drives, armature, gravity compensation

/// Checks what the arm reaches, whether its drives carry it there, and how it holds its home pose
/// and follows a motion at its limits. Only for a scene without errors.
void CheckMotion(Model& model);

}  // namespace rangegrasp::check::internal
