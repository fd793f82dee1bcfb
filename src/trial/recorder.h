#pragma once

#include <functional>
#include <memory>
#include <string>

#include "experiment/task.h"
#include "sim/render.h"
#include "trial/attempt.h"

namespace rangegrasp::trial {

/// Leaves what a person wants to see of attempts while they run: a picture of what is perceived and
/// of each moment of an execution (`<prefix>_perceived.png`, `<prefix>_lifted.png`, ...), all of
/// them on one sheet, and a film, where they are asked for. Unless a camera is named, the hand and
/// the object it is about are in each picture whole, and the way of the object since the picture
/// before.
class Recorder {
 public:
  virtual ~Recorder() = default;
  virtual const Detector& detector() const = 0;  ///< the cell's, looked at
  virtual sim::ExecutionObserver Observer() = 0;
  virtual void SetPrefix(const std::string& prefix) = 0;  ///< of the pictures that follow
  /// A picture of a moment that no execution names. @throws base::InputError for an unknown camera.
  virtual void Take(const std::string& moment, sim::World& world) = 0;
  /// Which moments of executions become pictures; all unless it is set.
  virtual void KeepMoments(std::function<bool(const std::string&)> wanted) = 0;
  /// Called with where each picture or frame is taken from, unless by a named camera.
  virtual void OnView(std::function<void(const std::string& moment, const sim::World& world,
                                         const sim::PinholeView& view)>
                          on_view) = 0;
  /// Writes the sheet, `<first prefix>_sheet.png`, and closes the film; of what never moved it
  /// shows the start. @throws base::RunError if ffmpeg failed.
  virtual void Finish() = 0;
};

/// The cell must outlive the recorder. Without pictures and film it only knows the cell's detector.
/// @throws base::NotBuilt for pictures or a film where the system that makes them is not built;
/// base::InputError if a film is asked for and there is no ffmpeg.
std::unique_ptr<Recorder> MakeRecorder(const Cell& cell, const std::string& prefix,
                                       const experiment::ReplayOptions& options);

using RecorderMaker = std::unique_ptr<Recorder> (*)(const Cell& cell, const std::string& prefix,
                                                    const experiment::ReplayOptions& options);
/// What makes those that take pictures.
void SetRecorderMaker(RecorderMaker maker);

}  // namespace rangegrasp::trial
