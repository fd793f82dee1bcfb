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

/// Options of a run of an experiment into a folder.
struct RunIntoOptions {
  int jobs = 1;
  int shard = 1;  ///< runs every `shards`-th case from this one on
  int shards = 1;
  bool resume = false;     ///< continues existing results
  bool overwrite = false;  ///< deletes existing results
  /// Gives the function called after each case of a run of `total` cases; absent: a ProgressBar.
  std::function<experiment::Progress(int before, int total)> progress = {};
  experiment::Processes processes = {};
  experiment::RunOptionNames names = {};
};

/// The result of a run.
struct Ran {
  std::filesystem::path folder;
  std::string failed = {};  ///< why the run as a whole failed; empty if it did not
  /// Present for a run of one seed (ReadResults pools several).
  experiment::Stamp stamp = {};
  std::optional<experiment::Report> report = {};
};

/// For opening an experiment whose cases are then run: warns of its findings and throws
/// base::InputError with all errors, which otherwise each case would find.
experiment::OnFindings RefuseErrors(const std::filesystem::path& file);

/// Runs an experiment into its folder, or with several seeds into one subfolder per seed: store,
/// experiment.yaml, the report's files. Warns of possible errors in the models.
/// @param out  results folder; empty: "results/" and the name of the experiment
/// @throws base::InputError for unusable models, with all reasons; if the folder contains results
/// of another run, or if it contains results that are neither to be resumed nor overwritten, or
/// both.
Ran RunExperiment(const std::filesystem::path& file, experiment::Changes changes,
                  const std::vector<std::uint64_t>& seeds, const std::filesystem::path& out,
                  const RunIntoOptions& options);

/// Parses "1,2,3"; an empty text gives none. @throws base::InputError.
std::vector<std::uint64_t> SeedsFrom(const std::string& text);

/// Adds --run-detector, for commands that reopen experiments.
void AddRunDetectorOption(CLI::App& command, bool& run_detector);

/// Whether a detector that is a Python function can be called now; set by the Python package.
bool& HasPythonDetector();

/// The experiment of a results folder, as it was run; warns of changes since then.
/// @throws base::InputError naming the folder; also as experiment::OpenAgain, and if its detector
/// was a Python function and there is none now.
experiment::Experiment ReopenExperiment(const experiment::Stamp& stamp, const std::string& folder,
                                        bool run_detector);

}  // namespace rangegrasp::cli
