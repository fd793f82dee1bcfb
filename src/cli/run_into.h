#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "experiment/experiment.h"
#include "experiment/runner.h"

namespace rangegrasp::cli {

/// How an experiment is run into a folder.
struct RunIntoOptions {
  int jobs = 1;
  int shard = 1;  ///< runs every `shards`-th case from this one on
  int shards = 1;
  bool resume = false;     ///< goes on with results that are there
  bool overwrite = false;  ///< throws them away
  /// Who is told of each case, of a run of `total` cases of which `before` are done; a ProgressBar
  /// where absent.
  std::function<experiment::Progress(int before, int total)> progress = {};
};

/// Looks for what a run would only find out trial after trial, and warns of what may be wrong.
/// @throws base::InputError with all errors.
void CheckBeforeRun(const std::filesystem::path& file, const experiment::Changes& changes);

/// One experiment of one seed into its folder: store, experiment.yaml, the report's files. The
/// first cases of each group are run before all others, and these only if not all of the first fail
/// in the same way. A run that is resumed after that goes on.
/// @return what has failed of the run as a whole; empty if nothing.
/// @throws base::InputError if the folder holds another run's results, or results at all and they
/// are neither to be resumed nor overwritten.
std::string RunInto(const std::filesystem::path& folder, const experiment::Experiment& e,
                    const RunIntoOptions& options);

/// Where an experiment was run into, and what has failed of it; empty if nothing.
struct Ran {
  std::filesystem::path folder;
  std::string failed;
};

/// The same of an experiment file: of its own seed, or of several, each in a folder of its own
/// below the results folder.
/// @param out  empty: "results/" and the name of the experiment
Ran RunExperiment(const std::filesystem::path& file, experiment::Changes changes,
                  const std::vector<std::uint64_t>& seeds, const std::filesystem::path& out,
                  const RunIntoOptions& options);

/// "1,2,3"; none of an empty text. @throws base::InputError.
std::vector<std::uint64_t> SeedsFrom(const std::string& text);

}  // namespace rangegrasp::cli
