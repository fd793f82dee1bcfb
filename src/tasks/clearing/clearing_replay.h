#pragma once

#include <functional>
#include <string>

#include "experiment/task.h"
#include "tasks/clearing/clear.h"

namespace rangegrasp::tasks::clearing {

/// Runs a case again under a viewer. With snapshots it leaves of attempt 3 of case pile-0001
/// `pile-0001_03_perceived.png`, `_03_start.png` and `_03_lifted.png`, `pile-0001_end.png`, and
/// `pile-0001_row.png`: the lifted objects and the end side by side.
experiment::Result ReplayClearing(
    const grasping::Cell& cell, const std::string& id, const experiment::ReplayOptions& options,
    const std::function<experiment::Result(const ClearingObserver&)>& run);

}  // namespace rangegrasp::tasks::clearing
