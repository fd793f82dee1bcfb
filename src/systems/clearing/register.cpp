#include "clearing/clearing_task.h"
#include "experiment/kinds.h"

namespace rangegrasp {

void RegisterClearing() { experiment::AddKind(clearing::ClearingTask()); }

}  // namespace rangegrasp
