#pragma once

#include <string>

#include "experiment/experiment.h"

namespace rangegrasp::cli {

/// The experiment of a results folder, as it was run; what has changed since is told.
/// @throws base::InputError naming the folder.
experiment::Experiment ReopenExperiment(const experiment::Stamp& stamp, const std::string& folder);

}  // namespace rangegrasp::cli
