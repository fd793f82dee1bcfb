#pragma once

#include "clearing/clear.h"
#include "experiment/report.h"

namespace rangegrasp::clearing {

/// The outcome of a run in which every object was delivered; otherwise it is the word of Stop.
inline constexpr const char* kCleared = "cleared";

/// The stored result of a run. Data: target (dropped last), objects, delivered, brought, left,
/// grasps, scans, perceived (in the last scan), stop, simulated_s, homing_s, per_object (object,
/// fate, grasps, why), attempts (each with the data of a single trial, and scan, object and held
/// (ground truth: the object aimed at and the object in the hand), try, felt, taken_away, outcome,
/// stage, detail). Seconds: each stage's sum over the run.
experiment::Result ResultOf(const Clearing& clearing, const std::string& target);

/// Tables of a clearing run: by arrangement (with intervals for clustered trials: the objects of a
/// run), by object with what happened to it otherwise, outcomes of the grasps.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::clearing
