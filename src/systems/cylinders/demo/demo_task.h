#pragma once

#include "experiment/task.h"

namespace rangegrasp::demo {

/// `task: demo`: the live demo of section 4.4. A case is one run: given cylinders among other
/// objects, one of them is wanted, grasped, and handed over or put down.
const experiment::TaskKind& DemoTask();

}  // namespace rangegrasp::demo
