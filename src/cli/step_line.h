#pragma once

#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "base/stopwatch.h"

namespace rangegrasp::cli {

/// A line on a terminal that tells what a long command is at and for how long, from its first
/// second on; nothing where stderr is none. A thread of its own keeps the clock going, so that no
/// step has to know of it.
class StepLine {
 public:
  /// @param title  "big.off"
  explicit StepLine(std::string title);
  ~StepLine() { End(); }
  StepLine(const StepLine&) = delete;
  StepLine& operator=(const StepLine&) = delete;

  void Begin(const std::string& step);
  /// Takes the line away, before anything else is written.
  void End();

 private:
  void Tick(const std::stop_token& stop);

  std::string title_, step_;
  base::Stopwatch watch_;
  std::mutex mutex_;
  std::condition_variable_any ends_;
  std::jthread thread_;  ///< last: it sees all others
};

}  // namespace rangegrasp::cli
