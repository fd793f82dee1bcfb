#pragma once

#include <span>

#include "experiment/task.h"

namespace rangegrasp::experiment {

/// Adds a kind of experiment: when the program starts.
void AddKind(const TaskKind& kind);

/// All that were added, in that order, in which help lists them, too.
std::span<const TaskKind> AllKinds();

}  // namespace rangegrasp::experiment
