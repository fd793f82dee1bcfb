#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/error.h"
#include "trial/cell.h"
#include "trial/options.h"

namespace rangegrasp::trial {

/// Result of trying a cell.
struct Tryout {
  int trials = 0, detected = 0, delivered = 0;
  std::vector<base::Finding> findings;  ///< errors first
  std::string Text() const;             ///< "27 trials tried: 27 detected, 26 delivered"
};

/// Default options of an experiment in a scene, with the line scanner.
Options OptionsOf(const std::filesystem::path& scene);

/// An error if the cell's sensor measures no point of the empty workspace, by one scan. Nothing is
/// said of a sensor that renders pictures: its threads must not exist when a later cell forks.
std::vector<base::Finding> CheckSight(const Cell& cell);

/// Runs trials (trial.h: arrange, scan, detect, plan, execute, judge) on generated objects instead
/// of the experiment's: a box, a cylinder and a ball, each in three sizes that fit the hand's
/// opening, alone on the table. The findings state what failed and why, with the measured value and
/// a fix. The fix for joints that lag behind, lower limits, is tested first. Failures are errors if
/// fewer than nine of ten trials deliver, otherwise warnings. The same options give the same
/// findings, unless the time limit of 45 s ends the trials early.
/// @param options  of a cell without errors (sim/check/check.h)
/// @param say  called with progress messages; may be empty
Tryout TryCell(Options options, const std::function<void(const std::string&)>& say = {});

}  // namespace rangegrasp::trial
