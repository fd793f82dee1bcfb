#include "trial/replay.h"

#include "trial/recorder.h"
#include "trial/view_recorder.h"

namespace rangegrasp::trial {
namespace {

experiment::Result ViewTrial(const Cell& cell, const TrialSpec& spec, experiment::View& view) {
  ViewRecorder recorder(cell);
  Attempt attempt;
  const auto result = RunTrial(cell, spec, &recorder.detector(), recorder.Observer(), &attempt);
  view = recorder.Finish(attempt);
  return result;
}

}  // namespace

experiment::Result ReplayTrial(const Cell& cell, const TrialSpec& spec,
                               const experiment::ReplayOptions& options) {
  if (options.view) return ViewTrial(cell, spec, *options.view);
  const auto recorder = MakeRecorder(cell, TrialId(spec), options);
  const auto result = RunTrial(cell, spec, &recorder->detector(), recorder->Observer());
  recorder->Finish();
  return result;
}

}  // namespace rangegrasp::trial
