#pragma once

#include "cylinders/task/demo_detector.h"
#include "experiment/task.h"
#include "trial/trial.h"

namespace rangegrasp::cylinders {

/// Whether the robot knows, by its own sensors, that there is something to be tried again: nothing
/// was found, planned, or held, and nobody has been offered anything.
bool KnowsItFailed(const trial::Attempt& attempt, Delivery delivery);

/// `task: cylinder_demo`: the live demo of section 4.4. A case is one run: given cylinders among
/// other objects, one of them is wanted, grasped, and handed over or put down.
const experiment::TaskKind& DemoTask();

}  // namespace rangegrasp::cylinders
