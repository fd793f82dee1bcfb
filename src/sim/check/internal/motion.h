#pragma once

#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {

/// What the arm reaches, whether its drives carry it there, how it holds its home pose and follows
/// a motion at its limits; only of a scene without errors.
void CheckMotion(Model& model);

}  // namespace rangegrasp::check::internal
