#pragma once

#include <vector>

#include "experiment/record.h"
#include "experiment/report.h"
#include "experiment/stamp.h"

namespace rangegrasp::recognition_task {

/// A row an object: how often it was found where it is, how often not, and why.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::recognition_task
