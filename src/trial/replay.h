#pragma once

#include "experiment/task.h"
#include "trial/trial.h"

namespace rangegrasp::trial {

/// Runs a trial again; leaves pictures of every stage (`<id>_perceived.png`, `<id>_lifted.png`,
/// ...) in the folder and a film of the execution, where they are asked for; or the view, where
/// that is.
/// @throws base::InputError if there is no such camera, or no ffmpeg for the film.
experiment::Result ReplayTrial(const Cell& cell, const TrialSpec& spec,
                               const experiment::ReplayOptions& options);

}  // namespace rangegrasp::trial
