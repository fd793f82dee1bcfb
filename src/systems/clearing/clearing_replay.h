#pragma once

#include <functional>
#include <string>

#include "clearing/clear.h"
#include "experiment/task.h"

namespace rangegrasp::clearing {

/// Runs a case again under a viewer. With snapshots it leaves of attempt 3 of case pile-0001
/// `pile-0001_03_perceived.png`, `_03_start.png` and `_03_lifted.png`, `pile-0001_end.png`, and
/// `pile-0001_row.png`: the lifted objects and the end side by side.
experiment::Result ReplayClearing(
    const trial::Cell& cell, const std::string& id, const experiment::ReplayOptions& options,
    const std::function<experiment::Result(const ClearingObserver&)>& run);

}  // namespace rangegrasp::clearing
