#pragma once

#include "experiment/report.h"
#include "seam/task/internal/table_parts.h"

namespace rangegrasp::seam_task::internal {

/// Tables 3.1 to 3.3 and 3.5, of seams that were drawn along: every method at four tolerances,
/// where on the line, every shape of edge, standard errors; rows.csv: a line a seam and method. A
/// case that crashed or timed out has an edge in every profile, found in none.
experiment::Report RatesReport(const Facts& facts, const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::seam_task::internal
