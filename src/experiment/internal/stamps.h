#pragma once

#include <string>
#include <string_view>

#include "experiment/record.h"

namespace rangegrasp::experiment::internal {

/// Whether a line of an experiment file ("seed: 1") or of --set ("seed=1") sets the seed or the
/// number of trials, which the experiment's hash leaves out: each is a value of the stamp.
inline bool SetsSeedOrTrials(std::string_view line, std::string_view trials_key) {
  const auto key = line.substr(0, line.find_first_of("=:"));
  return key == "seed" || key == trials_key;
}

/// Adds a commit to those that made a run's rows besides the first one, so that rows from different
/// commits do not look as if they came from one commit.
inline void AddCommit(const std::string& commit, Stamp& stamp) {
  if (commit.empty() || commit == ValueOr(stamp.build, "commit", "")) return;
  std::string& others = stamp.build["resumed_with"];
  if (others.find(commit) == std::string::npos) others += (others.empty() ? "" : ",") + commit;
}

}  // namespace rangegrasp::experiment::internal
