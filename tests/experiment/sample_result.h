#pragma once

#include "experiment/trial.h"

namespace rangegrasp::experiment {

/// A result with something in every field, made from its number alone.
inline TrialResult SampleResult(const TrialSpec& spec, std::uint64_t experiment_seed = 1) {
  TrialResult r;
  const int i = spec.index;
  r.id = TrialId(spec);
  r.object = spec.object;
  r.index = i;
  r.seed = TrialSeed(experiment_seed, spec);
  r.pose_class = "pose" + std::to_string(i % 3);
  r.redraws = i % 5;
  r.scan_points = 40000 + i;
  r.object_points = 3000 + i;
  r.segments = 2 + i;
  r.objects = 1 + i;
  r.candidates = 24;
  r.free_candidates = 20 - i % 7;
  r.plans = 1 + i % 4;
  r.grasp_type = "power";
  r.detected = i % 2 == 0;
  r.outcome = AllOutcomes()[static_cast<std::size_t>(i) % AllOutcomes().size()];
  r.stage = "score";
  r.detail = "trial " + std::to_string(i);
  r.log = R"({"lift_height_m":0.)" + std::to_string(i + 1) + "}";
  r.seconds = {{"scan", 0.1 + i}, {"perceive", 1.0 / (3.0 + i)}, {"trial", 1e-3 * i}};
  return r;
}

/// All that must not depend on how a trial was run.
inline std::string Row(TrialResult result) {
  result.seconds.clear();
  return ToJson(result);
}

}  // namespace rangegrasp::experiment
