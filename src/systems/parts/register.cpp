#include "cli/commands.h"
#include "experiment/kinds.h"
#include "grasp/selector.h"
#include "parts/command/parts_commands.h"
#include "parts/handle/handle_grasps.h"
#include "parts/task/parts_task.h"

namespace rangegrasp {

void RegisterParts() {
  experiment::AddKind(parts_task::PartsTask());
  grasp::AddGraspSelector({.word = "handle",
                           .about = "by the handle that their parts tell (chapter 6)",
                           .prepare = parts::JoinCutOffHandle,
                           .plan = parts::PlanHandleGrasps,
                           .firm = true});  // what hangs beside the pads would creep about them
  cli::AddCommand(cli::AddPartsCommands);
}

}  // namespace rangegrasp
