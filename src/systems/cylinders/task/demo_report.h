#pragma once

#include <string>

#include "cylinders/task/demo_detector.h"
#include "experiment/record.h"
#include "experiment/report.h"
#include "trial/trial.h"

namespace rangegrasp::cylinders {

/// How a run ended: the word of its attempt up to the carry; then handed_over, felt_early (the arm
/// took its own motion for a pull), not_felt, not_taken; where the cylinder is put down, the
/// attempt's own.
std::string OutcomeOf(const trial::Attempt& attempt, Delivery delivery);

/// Table 4.1: events of each kind of problem compared with the published ones, with and without
/// influence on the run; how many were handed over; how many pulls were felt.
experiment::Report DemoReport(const experiment::Stamp& stamp,
                              const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::cylinders
