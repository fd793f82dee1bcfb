// The steps of one profile of the base sensor, in the rows of table 3.1.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <vector>

#include "seam/calibration.h"
#include "seam/detectors.h"
#include "seam/monitor.h"
#include "seam/profile.h"
#include "seam/task/seam_experiment.h"
#include "seam/tracker.h"

namespace rangegrasp {
namespace {

// The recorded rows of a seam, the pre-processed profiles, and the data needed to make these.
struct Recorded {
  seam::SeamExperiment experiment;
  seam::Calibration calibration;
  std::vector<seam::RawProfile> raw;
  std::vector<seam::PreparedProfile> prepared;
};

const Recorded& Profiles() {
  static const Recorded recorded = [] {
    const std::filesystem::path root = RANGEGRASP_SOURCE_DIR;
    Recorded made;
    made.experiment = seam::ReadSeamExperiment(root / "experiments/seam_base.yaml");
    made.experiment.seed = 1001;
    const seam::StripeSensor sensor(made.experiment.sensor);
    made.calibration = seam::CalibrationOf(made.experiment, sensor);
    made.raw = seam::RecordSeam(made.experiment, sensor, 0).raw;
    for (const auto& raw : made.raw) {
      made.prepared.push_back(seam::Prepare(seam::Calibrate(raw, made.calibration), {}));
    }
    return made;
  }();
  return recorded;
}

// Runs `step(i)` on the profiles in turn.
template <class Step>
void OverProfiles(benchmark::State& state, Step step) {
  const std::size_t count = Profiles().raw.size();
  std::size_t i = 0;
  for (auto _ : state) {
    step(i);
    i = i + 1 < count ? i + 1 : 0;
  }
}

void ProfilePreProcessing(benchmark::State& state) {
  const Recorded& r = Profiles();
  OverProfiles(state, [&](std::size_t i) {
    benchmark::DoNotOptimize(seam::Prepare(seam::Calibrate(r.raw[i], r.calibration), {}));
  });
}
BENCHMARK(ProfilePreProcessing)->Unit(benchmark::kMicrosecond);

void ModelFitting(benchmark::State& state) {
  OverProfiles(state, [&](std::size_t i) {
    benchmark::DoNotOptimize(seam::FitEdgeModel(Profiles().prepared[i].height_m));
  });
}
BENCHMARK(ModelFitting)->Unit(benchmark::kMicrosecond);

void LocalWeightedVoting(benchmark::State& state) {
  OverProfiles(state, [&](std::size_t i) {
    benchmark::DoNotOptimize(seam::VoteLocally(Profiles().prepared[i].height_m));
  });
}
BENCHMARK(LocalWeightedVoting)->Unit(benchmark::kMicrosecond);

void GradientAccumulation(benchmark::State& state) {
  OverProfiles(state, [&](std::size_t i) {
    benchmark::DoNotOptimize(seam::AccumulateGradients(Profiles().prepared[i].height_m));
  });
}
BENCHMARK(GradientAccumulation)->Unit(benchmark::kMicrosecond);

// From the camera's rows to the decided position. The argument is the seam::DecisionMethod.
void SumIncludingDecision(benchmark::State& state) {
  const Recorded& r = Profiles();
  auto options = r.experiment.track.tracker;
  options.method = static_cast<seam::DecisionMethod>(state.range(0));
  seam::EdgeTracker tracker(options);
  double time_s = 0.0;
  OverProfiles(state, [&](std::size_t i) {
    auto profile = seam::Calibrate(r.raw[i], r.calibration);
    profile.time_s = time_s += 0.016;  // continues when the recording restarts
    benchmark::DoNotOptimize(tracker.Update(profile));
  });
}
BENCHMARK(SumIncludingDecision)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);

void SurfaceMonitorUpdate(benchmark::State& state) {
  const Recorded& r = Profiles();
  seam::SurfaceMonitor monitor(r.experiment.sensor.line, {});
  seam::Reading reading;
  reading.status = seam::ProfileStatus::kEdge;
  reading.step_m = 1e-3;
  OverProfiles(state, [&](std::size_t i) {
    benchmark::DoNotOptimize(monitor.Update(r.prepared[i], reading));
  });
}
BENCHMARK(SurfaceMonitorUpdate)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace rangegrasp
