#include "cli/commands.h"
#include "trial/registry.h"

namespace rangegrasp {

/// Of the systems that are built; CMake writes it (cmake/RangegraspSystems.cmake).
void RegisterSystems();

}  // namespace rangegrasp

// Puts the program together: the core, then what stands on it.
int main(int argc, char** argv) {
  rangegrasp::cli::ReportCrashes();
  rangegrasp::RegisterTrial();
  rangegrasp::RegisterSystems();
  return rangegrasp::cli::RunProgram(argc, argv);
}
