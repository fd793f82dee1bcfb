#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace rangegrasp::experiment {

/// How a trial ended (docs/architecture.md, definitions).
enum class Outcome {
  kDelivered,
  kNotSegmented,
  kWrongTarget,
  kNoGrasp,
  kNoPath,
  kNotLifted,
  kDropped,
  kMisplaced,
  kInvalidPhysics,
  kCrashed,
  kTimedOut,
};
const char* Name(Outcome outcome);
/// @throws core::InputError if there is no such outcome.
Outcome OutcomeFrom(const std::string& name);
const std::vector<Outcome>& AllOutcomes();

/// One trial's row in the store. All but `seconds` depend on the experiment, the seed and the trial
/// alone.
struct TrialResult {
  std::string id;  ///< "<object>-<index, 4 digits>"
  std::string object;
  int index = 0;  ///< from 0
  std::uint64_t seed = 0;
  std::string pose_class;
  int redraws = 0;  ///< arrangements drawn again
  int scan_points = 0;
  int object_points = 0;  ///< above the table, after the filters
  int segments = 0;
  int objects = 0;
  int candidates = 0;
  int free_candidates = 0;  ///< of these, not colliding
  int plans = 0;            ///< grasps offered to the planner
  std::string grasp_type;   ///< of the one executed, empty if none
  bool detected = false;
  Outcome outcome = Outcome::kCrashed;
  std::string stage;       ///< it ended in: arrange, scan, perceive, grasp, plan, execute, score
  std::string detail;      ///< one line for a person
  std::string log = "{}";  ///< JSON: what the simulation measured, audit included
  std::vector<std::pair<std::string, double>> seconds;  ///< wall time by stage
};

/// As one JSON object (a process hands its result over so). Round-trips exactly.
std::string ToJson(const TrialResult& result);
/// @throws core::RunError if the text is no result.
TrialResult FromJson(const std::string& text);

}  // namespace rangegrasp::experiment
