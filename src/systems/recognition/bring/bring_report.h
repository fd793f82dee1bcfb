#pragma once

#include "experiment/record.h"
#include "experiment/report.h"
#include "experiment/stamp.h"
#include "recognition/bring/bring_run.h"

namespace rangegrasp::bring {

/// What a run is stored as. Data: wanted, present, said, words, looks, cleared, look_s, homing_s,
/// simulated_s, attempts (each as a single trial records it, with at_wanted, taken_for, grasp,
/// asked_upright, touched_kept_free, outcome, stage, detail). Seconds: each stage's sum.
experiment::Result ResultOf(const Bring& run, const std::string& wanted, bool present);

/// Tables of a run: by object how many were handed over, by which grasps, with what is kept free
/// and upright; how many attempts and looks it took; of absent ones how many were said to be.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::bring
