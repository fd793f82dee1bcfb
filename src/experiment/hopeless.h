#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiment/record.h"

namespace rangegrasp::experiment {

/// The same cases in turn from each group: the first of every group, then the second, and so on.
std::vector<Case> InTurn(const std::vector<Case>& cases);

/// How all of the records failed, if they did so in the same way (the same outcome, in the same
/// stage): "no_path in plan: no_ik x24", with the detail that most of them share. nullopt if one of
/// them succeeded, they differ, or there are none.
std::optional<std::string> SameFailure(const std::vector<Record>& records,
                                       const std::string& success);

/// The distinct reasons of those that crashed, most frequent first: "2 x scan: no memory".
std::vector<std::string> CrashReasons(const std::vector<Record>& records);

}  // namespace rangegrasp::experiment
