#pragma once

#include <map>
#include <string>

#include "core/stopwatch.h"
#include "experiment/record.h"

namespace rangegrasp::cli {

/// A line on a terminal that tells how far a run is, with its outcomes and the time left; nothing
/// where stderr is none.
class ProgressBar {
 public:
  /// @param before  cases that an earlier part of the run has done
  ProgressBar(int before, int total) : before_(before), total_(total) {}
  void operator()(int done_now, int, const experiment::Record& last);

 private:
  int before_, total_;
  core::Stopwatch watch_;
  std::map<std::string, int> outcomes_;
};

}  // namespace rangegrasp::cli
