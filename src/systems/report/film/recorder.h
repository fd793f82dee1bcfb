#pragma once

#include "trial/recorder.h"

namespace rangegrasp::report {

/// Pictures, a sheet of them all, and a film. It stays where it was made.
class Recorder : public trial::Recorder {
 public:
  /// @throws base::InputError if a film is asked for and there is no ffmpeg.
  Recorder(const trial::Cell& cell, const std::string& prefix,
           const experiment::ReplayOptions& options);
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  const trial::Detector& detector() const override;
  sim::ExecutionObserver Observer() override;
  void SetPrefix(const std::string& prefix) override;
  void Take(const std::string& moment, sim::World& world) override;
  void KeepMoments(std::function<bool(const std::string&)> wanted) override;
  void OnView(std::function<void(const std::string& moment, const sim::World& world,
                                 const sim::PinholeView& view)>
                  on_view) override;
  void Finish() override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rangegrasp::report
