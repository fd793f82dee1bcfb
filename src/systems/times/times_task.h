#pragma once

#include "experiment/task.h"

namespace rangegrasp::times {

/// `task: times`: computing times on scans of published sizes. A case is a scene and a method; the
/// group is the method. Its keys are those of `task: grasping` but trials_per_object, and its own.
const experiment::TaskKind& TimesTask();

}  // namespace rangegrasp::times
