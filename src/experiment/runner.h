#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiment/store.h"

namespace rangegrasp::experiment {

/// How a run makes processes and waits for them. A program that is not C++ alone (Python) puts its
/// own in their place.
struct Processes {
  /// As fork(2).
  std::function<int()> fork = {};
  /// Calls the function, which waits; what it throws then ends the run and its processes.
  std::function<void(const std::function<void()>& wait)> wait = {};
};

struct RunOptions {
  int jobs = 1;                ///< cases at the same time, >= 1
  double case_limit_s = 60.0;  ///< wall time after which a case is killed
  Processes processes = {};
};

/// Runs a case, in a process of its own.
using CaseRunner = std::function<Result(const Case&)>;
/// Called in this process after every case, when its row is written.
using Progress = std::function<void(int done, int total, const Record& last)>;

/// Of all cases those of one shard (from 1) of so many: every n-th, from the shard-th on.
std::vector<Case> ShardOf(const std::vector<Case>& cases, int shard, int shards);

/// Without those that the store holds.
/// @param again_crashed  with those that it holds as kCrashed: a process that was killed, or that
/// had no memory, is no result. Where the crash is the case's own, it gives the same row again.
std::vector<Case> Missing(const std::vector<Case>& cases, const Store& store,
                          bool again_crashed = false);

/// Runs each case in a process forked from this one (a crash, an exception or a hang costs one
/// case), and writes it to the store as it ends. Results do not depend on the number of jobs or on
/// the order. This process must be single-threaded.
/// @throws base::RunError if the store cannot be written or no process be made.
void RunCases(const std::vector<Case>& cases, const CaseRunner& run, Store& store,
              const RunOptions& options, const Progress& progress);

/// The same without a store.
void RunCases(const std::vector<Case>& cases, const CaseRunner& run, const RunOptions& options,
              const Progress& done);

/// One case in a process of its own, as RunCases runs it; waits for it.
Result RunApart(const Case& which, double limit_s, const CaseRunner& run);

/// Makes a store that an earlier part of a run left ready to go on. The run may have more cases now
/// (more trials of each object): stored records take their places among them.
/// @param now    stamp of what goes on
/// @param cases  all of its cases, whatever the shard
/// @return the stamp to write: `now` with the commit that began the run; another commit is added to
/// "resumed_with".
/// @throws base::InputError naming the folder if it is another run's, or holds a case that is not
/// among `cases`; nothing is changed then.
Stamp Resume(Store& store, const Stamp& now, const std::vector<Case>& cases);

/// The same cases in turn from each group: the first of every group, then the second, and so on.
std::vector<Case> InTurn(const std::vector<Case>& cases);

/// How all of the records failed, if they have the same outcome in the same stage: "no_path in
/// plan: no_ik x24", with their most frequent detail. nullopt if one succeeded or there are none.
std::optional<std::string> SameFailure(const std::vector<Record>& records,
                                       const std::string& success);

/// The distinct reasons of those that crashed, most frequent first: "2 x scan: no memory".
std::vector<std::string> CrashReasons(const std::vector<Record>& records);

}  // namespace rangegrasp::experiment
