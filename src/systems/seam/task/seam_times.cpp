#include "seam/task/seam_times.h"

#include "base/stopwatch.h"
#include "seam/detectors.h"
#include "seam/preprocess.h"
#include "seam/tracker.h"

namespace rangegrasp::seam_task {

std::vector<std::pair<std::string, double>> TimeSteps(const SeamExperiment& experiment,
                                                      const seam::Calibration& calibration,
                                                      const stitching::Recording& recording) {
  std::vector<std::pair<std::string, double>> seconds;
  base::Stopwatch watch;
  const auto end_step = [&] { seconds.emplace_back(kTimedSteps[seconds.size()], watch.Restart()); };
  const seam::TrackerOptions options = TrackerFor(experiment, seam::DecisionMethod::kVoting);
  const seam::DetectorOptions& detectors = options.detectors;
  std::vector<seam::PreparedProfile> prepared;
  prepared.reserve(recording.raw.size());
  watch.Restart();
  for (const auto& raw : recording.raw) {
    prepared.push_back(seam::Prepare(seam::Calibrate(raw, calibration), options.preprocess));
  }
  end_step();
  for (const auto& profile : prepared)
    seam::FitEdgeModel(profile.height_m, detectors.model_fitting);
  end_step();
  for (const auto& profile : prepared)
    seam::VoteLocally(profile.height_m, detectors.local_weighted_voting);
  end_step();
  for (const auto& profile : prepared)
    seam::AccumulateGradients(profile.height_m, detectors.gradient_accumulation);
  end_step();
  seam::EdgeTracker tracker(options);
  watch.Restart();
  for (const auto& raw : recording.raw) tracker.Update(seam::Calibrate(raw, calibration));
  end_step();
  return seconds;
}

}  // namespace rangegrasp::seam_task
