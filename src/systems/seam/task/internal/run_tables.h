#pragma once

#include "experiment/report.h"
#include "seam/task/internal/table_parts.h"

namespace rangegrasp::seam_task::internal {

/// Of closed loops the errors along the path, of hazards how many were stopped for in time, and
/// which runs stopped early; rows.csv: a line a run. A case that crashed or timed out was not
/// followed or not stopped in time.
experiment::Report RunsReport(const Facts& facts, const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::seam_task::internal
