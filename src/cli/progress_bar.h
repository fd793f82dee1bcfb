#pragma once

#include <map>
#include <string>

#include "base/stopwatch.h"
#include "experiment/record.h"

namespace rangegrasp::cli {

/// A line on a terminal that tells how far a run is: cases, outcomes, how many a second and the
/// time left; nothing where stderr is none.
class ProgressBar {
 public:
  /// @param before   cases that an earlier part of the run has done
  /// @param success  the outcome whose share is told; empty: none
  ProgressBar(int before, int total, std::string success = "")
      : before_(before), total_(total), success_(std::move(success)) {}
  void operator()(int done_now, int, const experiment::Record& last);

 private:
  int before_, total_;
  std::string success_;
  base::Stopwatch watch_;
  std::map<std::string, int> outcomes_;
};

}  // namespace rangegrasp::cli
