#include "tasks/grasping/replay.h"

#include "tasks/grasping/recorder.h"

namespace rangegrasp::tasks::grasping {

experiment::Result ReplayTrial(const Cell& cell, const TrialSpec& spec,
                               const experiment::ReplayOptions& options) {
  Recorder recorder(cell, TrialId(spec), options);
  const auto result = RunTrial(cell, spec, &recorder.detector(), recorder.Observer());
  recorder.Finish();
  return result;
}

}  // namespace rangegrasp::tasks::grasping
