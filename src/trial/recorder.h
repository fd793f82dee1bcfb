#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "experiment/task.h"
#include "experiment/view.h"
#include "sim/render.h"
#include "trial/trial.h"

namespace rangegrasp::trial {

/// Records attempts while they run, on request: a picture of the perceived scene and of each moment
/// of an execution (`<prefix>_perceived.png`, `<prefix>_lifted.png`, ...), a sheet of all pictures,
/// and a video. Without a named camera, each picture shows the hand, its object, and the object's
/// path since the previous picture. The base class records nothing.
class Recorder {
 public:
  /// The cell must outlive the recorder.
  /// @param name  of the trial: the first prefix of its pictures
  explicit Recorder(const Cell& cell, std::string name = "")
      : cell_(cell), name_(std::move(name)) {}
  virtual ~Recorder() = default;
  /// The cell's, observed by the recorder.
  virtual const Detector& detector() const { return *cell_.detector; }
  virtual sim::ExecutionObserver Observer() { return {}; }
  virtual void SetPrefix(const std::string& /*prefix*/) {}  ///< of the following pictures
  /// Sets the prefix NAME_03 for attempt 3 of a run, NAME for 0.
  void SetAttempt(int number);
  /// Takes a picture at a moment that is not part of an execution.
  /// @throws base::InputError for an unknown camera.
  virtual void Take(const std::string& /*moment*/, sim::World& /*world*/) {}
  /// Selects the moments to take pictures of; empty, the default: all.
  virtual void KeepMoments(const std::vector<std::string>& /*moments*/) {}
  /// Sets a callback that gets the viewpoint of each picture or frame without a named camera.
  virtual void OnView(std::function<void(const std::string& moment, const sim::World& world,
                                         const sim::PinholeView& view)> /*on_view*/) {}
  /// Writes the sheet, `<first prefix>_sheet.png`, and closes the video. If nothing moved, the
  /// video shows the start.
  /// @throws base::RunError if ffmpeg failed.
  virtual void Finish() {}

 protected:
  const Cell& cell_;
  const std::string name_;
};

/// Makes a recorder. Without pictures and video it only provides the cell's detector. The cell must
/// outlive the recorder.
/// @throws base::NotBuilt for pictures or a video if the system that makes them is not built;
/// base::InputError for a video without ffmpeg.
std::unique_ptr<Recorder> MakeRecorder(const Cell& cell, const std::string& prefix,
                                       const experiment::ReplayOptions& options);

/// Makes recorders that take pictures; null if that system is not built.
using RecorderMaker = std::unique_ptr<Recorder> (*)(const Cell& cell, const std::string& prefix,
                                                    const experiment::ReplayOptions& options);
RecorderMaker& PictureMaker();

/// Records a trial for the 3D view: the scan in the colors of the perceived objects, their
/// completed surfaces, the grasps, and the moving bodies. The cell must outlive it.
class ViewRecorder {
 public:
  explicit ViewRecorder(const Cell& cell);
  ViewRecorder(const ViewRecorder&) = delete;
  ViewRecorder& operator=(const ViewRecorder&) = delete;

  const Detector& detector() const { return *detector_; }  ///< the cell's, observed by this
  sim::ExecutionObserver Observer();
  /// Completes and returns the recorded view.
  /// @param attempt  result of the trial
  experiment::View Finish(const Attempt& attempt);

 private:
  void OnMoment(const std::string& moment, const sim::World& world);

  const Cell& cell_;
  experiment::View view_;
  std::unique_ptr<Detector> detector_;  // writes into view_
  std::vector<int> bodies_;             // for each body of the view, its number in the world
};

}  // namespace rangegrasp::trial
