#pragma once

#include "experiment/record.h"
#include "experiment/report.h"
#include "experiment/stamp.h"

namespace rangegrasp::clearing {

/// Stamp::data: the title of an object.
using experiment::kTitlePrefix;

/// Tables of a clearing run: by arrangement (runs, objects delivered of all with an interval that
/// knows that objects of one run go together, grasps for each delivered object, stops, times), by
/// object, what was left and why, outcomes of the grasps.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::clearing
