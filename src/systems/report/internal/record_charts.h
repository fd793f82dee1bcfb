#pragma once

#include <string>
#include <vector>

#include "experiment/chart.h"
#include "experiment/record.h"
#include "experiment/stamp.h"

namespace rangegrasp::report::internal {

/// What records of any kind of experiment tell: outcomes of each group, outcomes of the cases that
/// ended in each stage without success, and how long stages took.
std::vector<experiment::Chart> RecordCharts(const experiment::Stamp& stamp,
                                            const std::vector<experiment::Record>& records,
                                            const std::string& success);

}  // namespace rangegrasp::report::internal
