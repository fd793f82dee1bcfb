#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "experiment/record.h"
#include "experiment/stamp.h"
#include "trial/attempt.h"

namespace rangegrasp::trial {

/// One attempt on one object. Each stage draws from its own stream of the trial's seed.
struct TrialSpec {
  std::string object;
  int index = 0;           ///< from 0
  std::uint64_t seed = 0;  ///< TrialSeed
};
/// "<object>-<index, 4 digits>".
std::string TrialId(const TrialSpec& spec);
/// Derived from (experiment seed, object, index) alone.
std::uint64_t TrialSeed(std::uint64_t experiment_seed, const std::string& object, int index);

/// Puts the titles of the experiment's objects into the stamp's data (experiment::TitleOf).
void AddTitles(const Options& options, experiment::Stamp& stamp);

/// Of a case for which no arrangement came about.
experiment::Result NoArrangement(const Redraws& redraws);

/// Stage 1 of a trial, as RunTrial goes through it.
std::optional<Arrangement> ArrangeTrial(const Cell& cell, const TrialSpec& spec);
std::optional<Arrangement> ArrangeTrial(const Cell& cell, const TrialSpec& spec, Redraws& redraws);

/// One trial from arrangement to judgement (docs/architecture.md). What a trial may run into is an
/// outcome. The result's data: pose_class, friction (static, glove on target), redraws,
/// redraw_reasons (how many of each), scene_objects, touching (objects that the target touches),
/// others_moved (by more than 5 mm), others_left_table, scan_points, object_points, segments,
/// objects, candidates, free_candidates, plans, blind, brushes, grasp_type, detected, log (what the
/// simulation measured, with the audit).
/// @param detector  in place of the cell's, so that a viewer can look on; may be null
/// @param seen  receives what each stage left; may be null
experiment::Result RunTrial(const Cell& cell, const TrialSpec& spec,
                            const Detector* detector = nullptr,
                            const sim::ExecutionObserver& observer = {}, Attempt* seen = nullptr);

}  // namespace rangegrasp::trial
