#pragma once

#include <string>

#include "cylinders/task/demo_detector.h"
#include "experiment/record.h"
#include "experiment/report.h"
#include "trial/trial.h"

namespace rangegrasp::cylinders {

/// Outcome of a run: the attempt's outcome up to the carry, then handed_over, felt_early (the arm
/// mistook its own motion for a pull), not_felt or not_taken. If the cylinder is put down, the
/// attempt's own outcome.
std::string OutcomeOf(const trial::Attempt& attempt, Delivery delivery);

/// Table 4.1: events of each kind of problem compared with the published ones, with and without
/// influence on the run; the number of handovers; the number of pulls that were felt.
experiment::Report DemoReport(const experiment::Stamp& stamp,
                              const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::cylinders
