#include "cli/commands.h"
#include "mesh/command/mesh_commands.h"

namespace rangegrasp {

void RegisterMesh() { cli::AddCommand(cli::AddAddObjectCommand); }

}  // namespace rangegrasp
