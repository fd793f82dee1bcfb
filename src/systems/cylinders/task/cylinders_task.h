#pragma once

#include "experiment/task.h"

namespace rangegrasp::cylinder_task {

/// `task: cylinders`: fits of single cylinders compared (tables 4.3 and 4.4). A case is one range
/// image, which all methods are given; the group is its source.
const experiment::TaskKind& CylindersTask();

}  // namespace rangegrasp::cylinder_task
