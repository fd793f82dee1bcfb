#include "trial/register.h"

#include "cli/commands.h"
#include "experiment/kinds.h"
#include "libraries.h"
#include "sim/info.h"
#include "trial/cell.h"
#include "trial/command/grasping_commands.h"
#include "trial/grasping_task.h"
#include "trial/internal/clutter_arranger.h"
#include "trial/internal/scattered_arranger.h"
#include "trial/internal/single_arranger.h"
#include "trial/listings.h"
#include "trial/registry.h"

namespace rangegrasp {
namespace {

using trial::Options;

void AddParts() {
  trial::AddSensor(
      {.word = trial::kLineScanner,
       .laser = [](const std::filesystem::path& file) { return file; },
       .files = [](const std::filesystem::path&) { return std::vector<std::filesystem::path>(); },
       .make =
           [](const trial::Cell& cell) {
             return trial::MakeLineScanner(cell.scanner, cell.robot.X_WScanner);
           }});
  trial::AddArranger({trial::kSingle, trial::internal::MakeSingleArranger});
  trial::AddArranger({trial::kScattered, trial::internal::MakeScatteredArranger});
  for (const char* word : {trial::kTouching, trial::kBox, trial::kPile}) {
    trial::AddArranger({word, trial::internal::MakeClutterArranger});
  }
  trial::AddDetector({.word = trial::kDissertation,
                      .make = [](const Options& options, const robot::Robot& robot,
                                 grasp::SceneObserver observer) {
                        return grasp::MakeDissertationDetector(options, robot, std::move(observer));
                      }});
}

}  // namespace

void RegisterTrial() {
  AddParts();
  experiment::AddKind(trial::GraspingTask());
  cli::AddCommand(cli::AddPictureCommands);
  cli::AddCommand(cli::AddPerceiveCommand);
  cli::AddCommand(cli::AddCheckCommand);
  trial::AddListings();
  cli::AddLibrary("mujoco", sim::EngineVersion());
  for (const auto& [name, version] : trial::kLibraries) cli::AddLibrary(name, version);
}

}  // namespace rangegrasp
