#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiment/store.h"

namespace rangegrasp::experiment {

/// How a run creates processes and waits for them. Python supplies its own functions.
struct Processes {
  std::function<int()> fork = {};  ///< like fork(2)
  /// Calls `wait`, which blocks. An exception from this function ends the run and its processes.
  std::function<void(const std::function<void()>& wait)> wait = {};
};

struct RunOptions {
  int jobs = 1;  ///< number of cases run in parallel, >= 1
  /// Computing time after which a case is killed, so that results do not depend on what else runs;
  /// a case that waits is killed after five times as long.
  double case_limit_s = 60.0;
  Processes processes = {};
};

/// Runs a case, in a process of its own.
using CaseRunner = std::function<Result(const Case&)>;
/// Called in this process after every case, when its row has been written.
using Progress = std::function<void(int done, int total, const Record& last)>;

/// The cases of one shard: every `shards`-th case, starting at the `shard`-th (from 1).
std::vector<Case> ShardOf(const std::vector<Case>& cases, int shard, int shards);

/// The cases that are not in the store.
/// @param again_crashed  also those stored as kCrashed: a process that was killed or had no memory
/// is not a result. If the case itself causes the crash, it gives the same row again.
std::vector<Case> Missing(const std::vector<Case>& cases, const Store& store,
                          bool again_crashed = false);

/// Runs each case in a process forked from this one (a crash, an exception or a hang costs only one
/// case), and writes it to the store when it ends. Results do not depend on the number of jobs or
/// on the order. This process must be single-threaded.
/// @throws base::RunError if the store cannot be written or a process cannot be created.
void RunCases(const std::vector<Case>& cases, const CaseRunner& run, Store& store,
              const RunOptions& options, const Progress& progress);

/// The same without a store.
void RunCases(const std::vector<Case>& cases, const CaseRunner& run, const RunOptions& options,
              const Progress& done);

/// Runs one case in its own process, as RunCases does, and waits for it.
Result RunApart(const Case& which, double limit_s, const CaseRunner& run);

/// The options of a run as messages name them: those of the command line, or, e.g., a function's.
struct RunOptionNames {
  std::string resume = "--resume", overwrite = "--overwrite", out = "--out DIR";
  std::string seeds = "--seeds N";
};

/// Prepares a store of an earlier part of a run for continuation. The run may have more cases now
/// (more trials of each object) and, in their order, more groups: stored records get their new
/// positions among them.
/// @param now    stamp of the continued run
/// @param cases  all of its cases, of all shards
/// @param names  for errors
/// @return the stamp to write: `now` with the commit that began the run; another commit is added to
/// "resumed_with".
/// @throws base::InputError naming the folder if it belongs to another run, or contains a case that
/// is not in `cases`; then nothing is changed.
Stamp Resume(Store& store, const Stamp& now, const std::vector<Case>& cases,
             const RunOptionNames& names = {});

/// The cases reordered by turns: the first of every group, then the second, and so on.
std::vector<Case> InTurn(const std::vector<Case>& cases);

/// How all of the records failed, if they have the same outcome in the same stage, with their most
/// frequent detail: "no_path in plan: no_ik x24". nullopt if one succeeded or there are none.
std::optional<std::string> SameFailure(const std::vector<Record>& records,
                                       const std::string& success);

/// The distinct reasons of crashed cases, most frequent first: "2 x scan: no memory".
std::vector<std::string> CrashReasons(const std::vector<Record>& records);

}  // namespace rangegrasp::experiment
