#pragma once

#include <functional>
#include <vector>

#include "experiment/record.h"
#include "experiment/store.h"

namespace rangegrasp::experiment {

struct RunOptions {
  int jobs = 1;                ///< cases at the same time, >= 1
  double case_limit_s = 60.0;  ///< wall time after which a case is killed
};

/// Called after every case, when its row is written.
using Progress = std::function<void(int done, int total, const Record& last)>;

/// Of all cases those of one shard (from 1) of so many: every n-th, from the shard-th on.
std::vector<Case> ShardOf(const std::vector<Case>& cases, int shard, int shards);

/// Without those that the store holds.
std::vector<Case> Missing(const std::vector<Case>& cases, const Store& store);

/// Runs the cases, each in a process of its own forked from this one (a crash, an exception or a
/// hang costs one case), and writes each to the store as it ends. Results do not depend on the
/// number of jobs or on the order. This process must be single-threaded.
/// @param run  called in the process of a case.
/// @throws base::RunError if the store cannot be written or no process be made; what was finished
/// is kept.
void RunCases(const std::vector<Case>& cases, const std::function<Result(const Case&)>& run,
              Store& store, const RunOptions& options, const Progress& progress);

/// The same without a store. @param done  called in this process as each case ends
void RunCases(const std::vector<Case>& cases, const std::function<Result(const Case&)>& run,
              const RunOptions& options, const Progress& done);

/// One case in a process of its own, as RunCases runs it; waits for it.
Result RunApart(const Case& which, double limit_s, const std::function<Result(const Case&)>& run);

}  // namespace rangegrasp::experiment
