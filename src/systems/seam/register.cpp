#include "cli/commands.h"
#include "experiment/kinds.h"
#include "seam/command/seam_commands.h"
#include "seam/command/seam_profile_file.h"
#include "seam/task/seam_task.h"

namespace rangegrasp {

void RegisterSeam() {
  experiment::AddKind(seam_task::SeamTask());
  cli::AddCommand(cli::AddSeamCommands);
  cli::AddListing({"formats", "every key of formats of profiles: the page docs/profile-formats.md",
                   cli::ProfileKeysPage, false});
}

}  // namespace rangegrasp
