#pragma once

#include "experiment/task.h"

namespace rangegrasp::recognition_task {

/// `task: recognition`: known objects are found with their poses. A case is one scene with a
/// target, arranged as a grasping trial's.
const experiment::TaskKind& RecognitionTask();

}  // namespace rangegrasp::recognition_task
