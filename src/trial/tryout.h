#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/error.h"
#include "trial/options.h"

namespace rangegrasp::trial {

/// What came of trying a cell.
struct Tryout {
  int trials = 0, detected = 0, delivered = 0;
  std::vector<base::Finding> findings;  ///< errors first
  std::string Text() const;             ///< "27 trials tried: 27 detected, 26 delivered"
};

/// The options of an experiment in a scene that says no more than its file, with the line scanner.
Options OptionsOf(const std::filesystem::path& scene);

/// Runs trials (trial.h: arrange, scan, detect, plan, execute, judge) on generated objects in place
/// of the experiment's: a box, a cylinder and a ball, each in three sizes that the hand's opening
/// allows, alone on the table. Says what failed and why, with the figure and a cure. A cure for
/// drives that fall behind, slower limits, is tried first. Failures are errors where fewer than
/// nine of ten trials deliver, else warnings. The same options give the same findings, unless the
/// time (45 s, then it stops with what it has) runs out.
/// @param options  of a cell without errors (sim/check/check.h)
/// @param say  called with what is being done; may be empty
Tryout TryCell(Options options, const std::function<void(const std::string&)>& say = {});

}  // namespace rangegrasp::trial
