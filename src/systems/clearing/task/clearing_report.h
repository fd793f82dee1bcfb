#pragma once

#include "clearing/clear.h"
#include "experiment/report.h"

namespace rangegrasp::clearing {

/// The outcome of a run of which every object was delivered; of others it is the stop's word.
inline constexpr const char* kCleared = "cleared";

/// What a run is stored as. Data: target (dropped last), objects, delivered, brought, left, grasps,
/// scans, perceived (in the last scan), stop, simulated_s, homing_s, per_object (object, fate,
/// grasps, why), attempts (each as a single trial records it, with scan, object and held (truth:
/// what it was at, what the hand had), try, felt, taken_away, outcome, stage, detail). Seconds:
/// each stage's sum over the run.
experiment::Result ResultOf(const Clearing& clearing, const std::string& target);

/// Tables of a clearing run: by arrangement (intervals are of clustered trials: a run's objects),
/// by object, what was left and why, outcomes of the grasps.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::clearing
