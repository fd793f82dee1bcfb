#pragma once

#include <memory>

#include "experiment/view.h"
#include "trial/attempt.h"

namespace rangegrasp::trial {

/// What there is to look at of a trial while it runs: the scan in the colours of the objects that
/// were perceived, their completed surfaces, the grasps, and what moved. Nothing of the trial
/// depends on being looked at. The cell must outlive it; it stays where it was made.
class ViewRecorder {
 public:
  explicit ViewRecorder(const Cell& cell);
  ~ViewRecorder();
  ViewRecorder(const ViewRecorder&) = delete;
  ViewRecorder& operator=(const ViewRecorder&) = delete;

  const Detector& detector() const;  ///< the cell's, looked at
  sim::ExecutionObserver Observer();
  /// All that was seen. @param attempt  what came of the trial
  experiment::View Finish(const Attempt& attempt);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rangegrasp::trial
