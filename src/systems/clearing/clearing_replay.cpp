#include "clearing/clearing_replay.h"

#include <fmt/format.h>

#include "trial/recorder.h"

namespace rangegrasp::clearing {
experiment::Result ReplayClearing(
    const trial::Cell& cell, const std::string& id, const experiment::ReplayOptions& options,
    const std::function<experiment::Result(const ClearingObserver&)>& run) {
  const auto recorder = trial::MakeRecorder(cell, id, options);
  recorder->KeepMoments([](const std::string& moment) {
    return moment == "start" || moment == "lifted" || moment == "end";
  });
  ClearingObserver observer;
  observer.detector = &recorder->detector();
  observer.execution = recorder->Observer();
  if (observer.execution.on_moment) {
    // The end of a grasp is the start of the next one, after the attendant.
    observer.execution.on_moment = [then = observer.execution.on_moment](const std::string& moment,
                                                                         sim::World& world) {
      if (moment != "end") then(moment, world);
    };
  }
  observer.on_attempt = [&](int attempt) {
    recorder->SetPrefix(fmt::format("{}_{:02}", id, attempt));
  };
  observer.on_end = [&](sim::World& world) {
    recorder->SetPrefix(id);
    recorder->Take("end", world);
  };
  const auto result = run(observer);
  recorder->Finish();
  return result;
}

}  // namespace rangegrasp::clearing
