#include "cli/commands.h"
#include "cylinders/command/cylinders_commands.h"
#include "cylinders/demo/demo_task.h"
#include "cylinders/task/cylinders_task.h"
#include "experiment/kinds.h"

namespace rangegrasp {

void RegisterCylinders() {
  experiment::AddKind(cylinder_task::CylindersTask());
  experiment::AddKind(demo::DemoTask());
  cli::AddCommand(cli::AddCylindersCommand);
}

}  // namespace rangegrasp
