#pragma once

#include <functional>
#include <string>

#include "base/stopwatch.h"
#include "experiment/record.h"

namespace rangegrasp::experiment::internal {

/// A case in a process of its own, forked from this one; its result comes through a pipe.
class Worker {
 public:
  /// @param run  called in the child; whatever it prints does not mix with what this process
  /// prints.
  /// @throws base::RunError if no process or pipe can be made.
  Worker(const Case& which, double limit_s, const std::function<Result(const Case&)>& run);
  /// Kills the process if it still runs.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  int pipe() const { return pipe_; }
  const Case& which() const { return which_; }
  /// Wall time left until the limit [s].
  double Left() const { return limit_s_ - watch_.Seconds(); }
  /// Takes what the pipe holds; true when the process has closed it.
  bool Read();
  /// The result, after the pipe's end; waits for the process's end for a short time.
  Result Finish();
  /// Kills the process: kTimedOut.
  Result TimeOut();

 private:
  [[noreturn]] void RunChild(int parent, int out,
                             const std::function<Result(const Case&)>& run) noexcept;
  std::string LastLine() const;
  Result Failed(const char* outcome, const std::string& detail) const;

  Case which_;
  double limit_s_;
  base::Stopwatch watch_;
  int pid_ = -1;
  int pipe_ = -1;
  int log_ = -1;
  std::string text_;
};

}  // namespace rangegrasp::experiment::internal
