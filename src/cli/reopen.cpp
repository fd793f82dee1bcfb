#include "cli/reopen.h"

#include <spdlog/spdlog.h>

#include "base/error.h"
#include "base/systems.h"
#include "experiment/kinds.h"

namespace rangegrasp::cli {

experiment::Experiment ReopenExperiment(const experiment::Stamp& stamp, const std::string& folder) {
  try {
    auto e = experiment::OpenAgain(stamp, experiment::AllKinds());
    for (const auto& [name, value] : e.stamp.identity) {
      const auto was = stamp.identity.find(name);
      if (was != stamp.identity.end() && was->second != value) {
        spdlog::warn("the {} has changed since the run: results may differ", name);
      }
    }
    return e;
  } catch (const base::NotBuilt&) {
    throw;  // who started the program may build it
  } catch (const base::InputError& error) {
    throw base::InputError(folder + ": " + error.what());
  }
}

}  // namespace rangegrasp::cli
