#include "trial/recorder.h"

#include "base/systems.h"

namespace rangegrasp::trial {
namespace {

RecorderMaker& Maker() {
  static RecorderMaker maker = nullptr;
  return maker;
}

// Of a trial that is run again for its record alone.
class NoRecorder : public Recorder {
 public:
  explicit NoRecorder(const Cell& cell) : cell_(cell) {}
  const Detector& detector() const override { return *cell_.detector; }
  sim::ExecutionObserver Observer() override { return {}; }
  void SetPrefix(const std::string&) override {}
  void Take(const std::string&, sim::World&) override {}
  void KeepMoments(std::function<bool(const std::string&)>) override {}
  void OnView(std::function<void(const std::string&, const sim::World&, const sim::PinholeView&)>)
      override {}
  void Finish() override {}

 private:
  const Cell& cell_;
};

}  // namespace

void SetRecorderMaker(RecorderMaker maker) { Maker() = maker; }

std::unique_ptr<Recorder> MakeRecorder(const Cell& cell, const std::string& prefix,
                                       const experiment::ReplayOptions& options) {
  if (!options.snapshots && options.video.empty()) return std::make_unique<NoRecorder>(cell);
  if (Maker()) return Maker()(cell, prefix, options);
  base::CheckBuilt("option", options.snapshots ? "snapshots" : "video");
  throw base::InputError("this program was built without pictures and films of trials");
}

}  // namespace rangegrasp::trial
