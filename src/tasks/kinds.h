#pragma once

#include <span>

#include "experiment/task.h"

namespace rangegrasp::tasks {

/// All kinds of experiments, in the order in which help lists them.
std::span<const experiment::TaskKind> AllKinds();

}  // namespace rangegrasp::tasks
