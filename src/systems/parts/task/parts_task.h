#pragma once

#include "experiment/task.h"

namespace rangegrasp::parts_task {

/// `task: parts`: methods that take an object apart against the segmentations of people (chapter 6,
/// figures 6.19-6.22, table 6.1). A case is one method on one model, e.g. "cup-0021-mirror"; its
/// group is the model's class.
const experiment::TaskKind& PartsTask();

}  // namespace rangegrasp::parts_task
