#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiment/experiment.h"
#include "experiment/runner.h"

namespace CLI {
class App;
}  // namespace CLI

namespace rangegrasp::cli {

/// How an experiment is run into a folder.
struct RunIntoOptions {
  int jobs = 1;
  int shard = 1;  ///< runs every `shards`-th case from this one on
  int shards = 1;
  bool resume = false;     ///< goes on with results that are there
  bool overwrite = false;  ///< throws them away
  /// What is called after each case of a run of `total` cases; a ProgressBar where absent.
  std::function<experiment::Progress(int before, int total)> progress = {};
  experiment::Processes processes = {};
};

/// What a run left.
struct Ran {
  std::filesystem::path folder;
  std::string failed = {};  ///< what has failed of it as a whole; empty if nothing
  /// Of a run of one seed (ReadResults pools several).
  experiment::Stamp stamp = {};
  std::optional<experiment::Report> report = {};
};

/// Runs an experiment into its folder, or with several seeds each into a folder below that: store,
/// experiment.yaml, the report's files. Warns of what may be wrong with the models.
/// @param out  empty: "results/" and the name of the experiment
/// @throws base::InputError for models that cannot work, with all reasons; if the folder holds
/// another run's results, or results at all and they are neither to be resumed nor overwritten.
Ran RunExperiment(const std::filesystem::path& file, experiment::Changes changes,
                  const std::vector<std::uint64_t>& seeds, const std::filesystem::path& out,
                  const RunIntoOptions& options);

/// "1,2,3"; none of an empty text. @throws base::InputError.
std::vector<std::uint64_t> SeedsFrom(const std::string& text);

/// --run-detector, for commands that reopen experiments.
void AddRunDetectorOption(CLI::App& command, bool& run_detector);

/// The experiment of a results folder, as it was run; warns of what has changed since.
/// @throws base::InputError naming the folder; also as experiment::OpenAgain.
experiment::Experiment ReopenExperiment(const experiment::Stamp& stamp, const std::string& folder,
                                        bool run_detector);

}  // namespace rangegrasp::cli
