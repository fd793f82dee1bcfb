#pragma once

#include <functional>
#include <memory>
#include <string>

#include "experiment/task.h"
#include "experiment/view.h"
#include "sim/render.h"
#include "trial/trial.h"

namespace rangegrasp::trial {

/// Leaves what a person wants to see of attempts while they run: a picture of what is perceived and
/// of each moment of an execution (`<prefix>_perceived.png`, `<prefix>_lifted.png`, ...), all of
/// them on one sheet, and a film, where they are asked for. Unless a camera is named, each picture
/// shows the hand, its object, and the object's way since the picture before.
class Recorder {
 public:
  virtual ~Recorder() = default;
  virtual const Detector& detector() const = 0;  ///< the cell's, looked at
  virtual sim::ExecutionObserver Observer() { return {}; }
  virtual void SetPrefix(const std::string& /*prefix*/) {}  ///< of the pictures that follow
  /// A picture of a moment that no execution names.
  /// @throws base::InputError for an unknown camera.
  virtual void Take(const std::string& /*moment*/, sim::World& /*world*/) {}
  /// Which moments of executions become pictures; all unless it is set.
  virtual void KeepMoments(std::function<bool(const std::string&)> /*wanted*/) {}
  /// Called with where each picture or frame is taken from, unless by a named camera.
  virtual void OnView(std::function<void(const std::string& moment, const sim::World& world,
                                         const sim::PinholeView& view)> /*on_view*/) {}
  /// Writes the sheet, `<first prefix>_sheet.png`, and closes the film; of what never moved it
  /// shows the start.
  /// @throws base::RunError if ffmpeg failed.
  virtual void Finish() {}
};

/// The cell must outlive the recorder. Without pictures and film it only knows the cell's detector.
/// @throws base::NotBuilt for pictures or a film where the system that makes them is not built;
/// base::InputError if a film is asked for and there is no ffmpeg.
std::unique_ptr<Recorder> MakeRecorder(const Cell& cell, const std::string& prefix,
                                       const experiment::ReplayOptions& options);

/// What makes those that take pictures; null where there is none.
using RecorderMaker = std::unique_ptr<Recorder> (*)(const Cell& cell, const std::string& prefix,
                                                    const experiment::ReplayOptions& options);
RecorderMaker& PictureMaker();

/// What there is to look at of a trial while it runs: the scan in the colors of the perceived
/// objects, their completed surfaces, the grasps, and what moved. The cell must outlive it; it
/// stays where it was made.
class ViewRecorder {
 public:
  explicit ViewRecorder(const Cell& cell);
  ViewRecorder(const ViewRecorder&) = delete;
  ViewRecorder& operator=(const ViewRecorder&) = delete;

  const Detector& detector() const { return *detector_; }  ///< the cell's, looked at
  sim::ExecutionObserver Observer();
  /// All that was seen.
  /// @param attempt  what came of the trial
  experiment::View Finish(const Attempt& attempt);

 private:
  void OnMoment(const std::string& moment, const sim::World& world);

  const Cell& cell_;
  experiment::View view_;
  std::unique_ptr<Detector> detector_;  // writes into view_
  std::vector<int> bodies_;             // of each of the view's bodies: its number in the world
};

}  // namespace rangegrasp::trial
