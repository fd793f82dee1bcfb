#pragma once

#include "experiment/task.h"

namespace rangegrasp::clearing {

/// `task: clearing`: arrangements of several objects are cleared, one case an arrangement; the
/// group is the arrangement's word. Its keys are those of `task: grasping` but trials_per_object,
/// and its own.
const experiment::TaskKind& ClearingTask();

}  // namespace rangegrasp::clearing
