#pragma once

#include "experiment/record.h"
#include "experiment/report.h"

namespace rangegrasp::cylinders {

/// Table 4.1: events of each kind of problem compared with the published ones, with and without
/// influence on the run; the number of handovers; the number of pulls that were felt.
experiment::Report DemoReport(const experiment::Stamp& stamp,
                              const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::cylinders
