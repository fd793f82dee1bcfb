#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "experiment/grid.h"

namespace rangegrasp::experiment {

/// The smallest thing that is run, stored and repeated: one grasp trial, one seam, one method on
/// one model. It depends on the experiment and on itself alone.
struct Case {
  std::string id;             ///< unique in its experiment: letters, digits, '_', '-', '.'
  std::string group;          ///< what --objects chooses by: an object, a class, a shape of edge
  std::uint64_t seed = 0;     ///< derived from the experiment's seed and this case alone
  std::string params = "{}";  ///< JSON object: what the case is, in the task's own words
  int position = 0;           ///< among the experiment's cases, from 0; the engine sets it
};

/// What running a case gave.
struct Result {
  std::string outcome;      ///< one word of the task's, or kCrashed or kTimedOut
  std::string stage;        ///< that it ended in
  std::string detail;       ///< one line for a person
  std::string data = "{}";  ///< JSON object: figures, written so that they are read back the same
  /// Time by stage [s]: all that may differ between two runs of the same case.
  std::vector<std::pair<std::string, double>> seconds;
};
/// The engine's own outcomes: the process ended without a result, or was killed at its time limit.
/// Their `data` is "{}".
inline constexpr const char* kCrashed = "crashed";
inline constexpr const char* kTimedOut = "timed_out";

/// A row of the store.
struct Record {
  Case which;
  Result result;
};

/// As one JSON object for people and programs; `params` and `data` stand in it as objects, bytes
/// that are no UTF-8 are replaced. @throws base::RunError if they are no JSON.
std::string ToJson(const Record& record);

/// A row a record, with the same names as in JSON: "id", "params.index", "data.log.lift_height_m",
/// "seconds.scan"; a column for each name that any of them has, empty where a record has none.
/// @throws base::RunError as ToJson.
Grid FlatGridOf(const std::vector<Record>& records);

/// Whether two records say the same but for their times.
bool SameButTimes(const Record& a, const Record& b);

}  // namespace rangegrasp::experiment
