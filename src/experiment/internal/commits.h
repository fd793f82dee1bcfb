#pragma once

#include <string>

#include "experiment/record.h"

namespace rangegrasp::experiment::internal {

/// Adds a commit to those that made a run's rows besides the first one, so that rows from different
/// commits do not look as if they came from one commit.
inline void AddCommit(const std::string& commit, Stamp& stamp) {
  if (commit.empty() || commit == ValueOr(stamp.build, "commit", "")) return;
  std::string& others = stamp.build["resumed_with"];
  if (others.find(commit) == std::string::npos) others += (others.empty() ? "" : ",") + commit;
}

}  // namespace rangegrasp::experiment::internal
