#pragma once

#include <vector>

#include "experiment/chart.h"
#include "experiment/record.h"
#include "experiment/stamp.h"

namespace rangegrasp::trial {

/// The rates of the table by object, beside the published ones; then what they depend on: how the
/// object lies, the kind of grasp, friction, and how far the object slid and turned in the hand.
/// What no record tells is left out. @throws base::InputError as BuildTable.
std::vector<experiment::Chart> ChartsOf(const experiment::Stamp& stamp,
                                        const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::trial
