#pragma once

#include <memory>
#include <string>

#include "experiment/record.h"
#include "experiment/report.h"
#include "experiment/task.h"
#include "recognition/bring/bring_run.h"

namespace rangegrasp::bring {

/// `task: bring`: a wanted object among others is looked for, taken and handed over (section 7.2).
/// A case is one run; the group is the wanted object.
const experiment::TaskKind& BringTask();

/// One run of an experiment of that kind, in words while it goes, with pictures if the options ask
/// for them.
/// @param task  of `task: bring`
/// @throws base::InputError if it is of another kind.
experiment::Result BringAloud(const experiment::Task& task, const experiment::Case& which,
                              const std::function<void(const std::string&)>& say,
                              const experiment::ReplayOptions& options);

/// What a run is stored as. Data: wanted, present, said, words, looks, cleared, look_s, homing_s,
/// simulated_s, attempts (each as a single trial records it, with at_wanted, taken_for, grasp,
/// asked_upright, touched_kept_free, outcome, stage, detail). Seconds: each stage's sum.
experiment::Result ResultOf(const Bring& run, const std::string& wanted, bool present);

/// Tables of a run: by object how many were handed over, by which grasps, with what is kept free
/// and upright; how many attempts and looks it took; of absent ones how many were said to be.
experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records);

}  // namespace rangegrasp::bring
