#pragma once

#include "experiment/task.h"
#include "trial/trial.h"

namespace rangegrasp::trial {

/// `task: grasping`: grasp attempts in simulation (chapter 5), with one case per trial and one
/// table row per object.
const experiment::TaskKind& GraspingTask();

/// The trials of an experiment, object by object.
std::vector<experiment::Case> TrialsOf(const Options& options, std::uint64_t seed);

/// The work cell of a grasping experiment.
/// @throws base::InputError if the task is of another kind.
const Cell& CellOf(const experiment::Task& task);

}  // namespace rangegrasp::trial
