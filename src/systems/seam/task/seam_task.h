#pragma once

#include "experiment/task.h"

namespace rangegrasp::seam_task {

/// Chapter 3: a case is one recorded seam (`seam-0007`; its group is the shape of its edge), or one
/// closed-loop run with one way to decide (`run-0004-voting`; its group is that way, or what the
/// head runs towards).
const experiment::TaskKind& SeamTask();

}  // namespace rangegrasp::seam_task
