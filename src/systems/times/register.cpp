#include "experiment/kinds.h"
#include "times/times_task.h"

namespace rangegrasp {

void RegisterTimes() { experiment::AddKind(times::TimesTask()); }

}  // namespace rangegrasp
