#pragma once

#include <map>
#include <string>
#include <vector>

#include "clearing/clear.h"
#include "experiment/record.h"

namespace rangegrasp::clearing {

/// The outcome of a run of which every object was delivered; of others it is the stop's word.
inline constexpr const char* kCleared = "cleared";

/// What a run is stored as. Data: target (dropped last), objects, delivered, brought, left, grasps,
/// scans, perceived (in the last scan), stop, simulated_s, homing_s, per_object (object, fate,
/// grasps, why), attempts (each as a single trial records it, with scan, object and held (truth:
/// what it was at, what the hand had), try, felt, taken_away, outcome, stage, detail). Seconds:
/// each stage's sum over the run.
experiment::Result ResultOf(const Clearing& clearing, const std::string& target);

/// What the tables need of a stored run.
struct ClearedCase {
  std::string group, outcome;
  bool recorded = false;  ///< not of one that crashed or timed out
  int objects = 0, delivered = 0, brought = 0, grasps = 0, scans = 0, attempts = 0;
  double robot_s = 0.0;  ///< simulated, with the ways home
  std::map<std::string, double> seconds;
  std::vector<ObjectEnd> ends;
  std::map<std::string, int> grasp_outcomes;
  int felt_wrong = 0;  ///< grasps in which the hand's feeling and the target's delivery disagree
};
/// Of a case without data (crashed, timed out) no object was delivered.
ClearedCase ReadCase(const experiment::Record& record);

}  // namespace rangegrasp::clearing
