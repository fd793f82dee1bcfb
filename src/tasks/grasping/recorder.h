#pragma once

#include <functional>
#include <memory>
#include <string>

#include "experiment/task.h"
#include "sim/render.h"
#include "tasks/grasping/attempt.h"

namespace rangegrasp::tasks::grasping {

/// Leaves what a person wants to see of attempts while they run: a picture of what is perceived and
/// of each moment of an execution (`<prefix>_perceived.png`, `<prefix>_lifted.png`, ...), all of
/// them on one sheet, and a film, where they are asked for. Unless a camera is named, the hand and
/// the object it is about are in each picture whole, and the way of the object since the picture
/// before. The cell must outlive it; it stays where it was made.
class Recorder {
 public:
  /// @throws core::InputError if a film is asked for and there is no ffmpeg.
  Recorder(const Cell& cell, const std::string& prefix, const experiment::ReplayOptions& options);
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  const Detector& detector() const;  ///< the cell's, looked at
  sim::ExecutionObserver Observer();
  void SetPrefix(const std::string& prefix);  ///< of the pictures that follow
  /// A picture of a moment that no execution names. @throws core::InputError for an unknown camera.
  void Take(const std::string& moment, sim::World& world);
  /// Which moments of executions become pictures; all unless it is set.
  void KeepMoments(std::function<bool(const std::string&)> wanted);
  /// Called with where each picture or frame is taken from, unless by a named camera.
  void OnView(std::function<void(const std::string& moment, const sim::World& world,
                                 const sim::PinholeView& view)>
                  on_view);
  /// Writes the sheet, `<first prefix>_sheet.png`, and closes the film; of what never moved it
  /// shows the start. @throws core::RunError if ffmpeg failed.
  void Finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rangegrasp::tasks::grasping
