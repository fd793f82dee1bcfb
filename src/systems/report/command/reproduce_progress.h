#pragma once

#include <string>

#include "base/stopwatch.h"

namespace rangegrasp::cli {

/// What is to be run: one experiment, or several together.
struct PlannedCases {
  int all = 0;          ///< done or not
  int stored = 0;       ///< done by an earlier run
  double left_s = 0.0;  ///< what the others take, as far as it is known before
};

/// How far several runs are: a line on a terminal with the time left of all; without one a message
/// at the begin of each run.
class ReproduceProgress {
 public:
  explicit ReproduceProgress(const PlannedCases& all) : all_(all) {}

  /// A run begins. @param name  "table 5.2"
  void Begin(const std::string& name, const PlannedCases& run);
  void OneDone();
  /// It is over, whether or not all of its cases were run.
  void End();

 private:
  double LeftSeconds() const;

  PlannedCases all_;
  PlannedCases run_;
  std::string name_;
  base::Stopwatch watch_;
  int done_ = 0;          // of the run's cases that were not stored
  int before_ = 0;        // cases of earlier runs
  double spent_s_ = 0.0;  // planned, of what was run
};

}  // namespace rangegrasp::cli
