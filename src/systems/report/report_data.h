#pragma once

#include <cstddef>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "experiment/results.h"
#include "experiment/task.h"

namespace rangegrasp::report {

/// A run that is reported on.
struct Run {
  std::string name;
  const experiment::TaskKind* kind = nullptr;
  experiment::Results results;
  experiment::Report tables;
};

/// Writes what the page shows of runs into a report's folder: `data.js` (tables, charts, pairs, a
/// line a case) and `records/<i>.js` (all of a case's record), which are loaded when a case is
/// looked at. Cases are numbered from 0, run after run.
/// @param views  numbers of the cases that have one
/// @param note   a sentence about which have one; may be empty
/// @throws base::InputError as the kinds' charts.
void WriteData(const std::vector<Run>& runs, const std::set<std::size_t>& views,
               const std::string& note, const std::filesystem::path& folder);

}  // namespace rangegrasp::report
