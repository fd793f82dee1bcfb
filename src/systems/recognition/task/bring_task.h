#pragma once

#include <string>

#include "experiment/record.h"
#include "experiment/report.h"
#include "experiment/task.h"
#include "recognition/bring/bring_run.h"

namespace rangegrasp::bring {

/// `task: bring`: a wanted object among others is searched for, grasped and handed over (section
/// 7.2). A case is one run; the group is the wanted object.
const experiment::TaskKind& BringTask();

/// The stored result of a run. Data: wanted, present, friction, said, words, looks, cleared,
/// homing_s, simulated_s, attempts (each as in a single trial, with at_wanted, taken_for, grasp,
/// asked_upright, touched_kept_free, outcome, stage, detail). Seconds: the sum of each stage.
experiment::Result ResultOf(const Bring& run, const std::string& wanted, bool present);

/// Tables of runs, by object: handovers and their grasps, whether keep-free parts stayed free and
/// the object upright, attempts and looks; for absent objects, how many were reported absent.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::bring
