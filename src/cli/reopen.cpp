#include "cli/reopen.h"

#include <spdlog/spdlog.h>

#include "core/error.h"
#include "tasks/kinds.h"

namespace rangegrasp::cli {

experiment::Experiment ReopenExperiment(const experiment::Stamp& stamp, const std::string& folder) {
  try {
    auto e = experiment::OpenAgain(stamp, tasks::AllKinds());
    for (const auto& [name, value] : e.stamp.identity) {
      const auto was = stamp.identity.find(name);
      if (was != stamp.identity.end() && was->second != value) {
        spdlog::warn("the {} has changed since the run: results may differ", name);
      }
    }
    return e;
  } catch (const core::InputError& error) {
    throw core::InputError(folder + ": " + error.what());
  }
}

}  // namespace rangegrasp::cli
