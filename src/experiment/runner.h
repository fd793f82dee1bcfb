#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "experiment/store.h"
#include "experiment/trial.h"

namespace rangegrasp::experiment {

struct RunOptions {
  int jobs = 1;         ///< trials at the same time, >= 1
  bool resume = false;  ///< leave out trials that the store holds
  int shard = 1;        ///< of shards, from 1: trials with number % shards == shard - 1
  int shards = 1;
};

/// Called after every trial.
using Progress = std::function<void(int done, int total, const TrialResult& last)>;

/// What identifies a run: version, commit, hashes, seed, trials, engine, titles and the published
/// table.
std::map<std::string, std::string> MakeStamp(const Experiment& experiment);

/// The trials of a run and how one is run.
struct RunPlan {
  std::vector<TrialSpec> trials;  ///< all of them, whatever the shard
  std::uint64_t seed = 1;         ///< the experiment's; of the row of a trial that hands over none
  double trial_limit_s = 60.0;    ///< wall time after which a trial is killed
  std::function<TrialResult(const TrialSpec&)> run;  ///< called in a process of its own
};

/// Runs the trials, each in a process of its own (a crash, an exception or a hang costs one trial:
/// `crashed`, `timed_out`), and writes each to the store as it ends. Results do not depend on jobs,
/// shards or order.
/// @throws core::RunError if the store cannot be written or no process be made; what was finished
/// is kept.
void RunTrials(const RunPlan& plan, Store& store, const RunOptions& options,
               const Progress& progress);

/// The same for an experiment's trials.
void RunExperiment(const TrialContext& context, Store& store, const RunOptions& options,
                   const Progress& progress);

}  // namespace rangegrasp::experiment
