#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "trial/cell.h"
#include "trial/judge.h"

namespace rangegrasp::trial {

/// The stream that a stage draws from.
base::Rng StageStream(std::uint64_t seed, std::string_view stage);

/// Stage 2, at a settled world. Draws from the seed's stream "scan".
Sensed Look(const Cell& cell, const sim::World& world, std::uint64_t seed);

/// What one further look, from the wrist, was (Registry: FurtherLooks).
struct LookRecord {
  double gain_m3 = 0.0;    ///< new space that it was expected to see
  double unseen_m3 = 0.0;  ///< of all that was not seen
  double way_s = 0.0;      ///< of the arm
  bool arrived = false;    ///< and did look
  /// Its pose was corrected by what it and the views before see alike.
  bool refined = false;
  double deviations = 0.0;  ///< size of the correction in deviations of the error
  double sigma_m = 0.0;
  std::size_t pairs = 0;
};

/// All looks of a trial: what was sensed, and where the arm stands after it.
struct LookedAround {
  Sensed sensed;
  Eigen::VectorXd q;
  std::vector<LookRecord> looks;  ///< from the wrist
};

/// What an attempt is told.
struct AttemptOptions {
  std::uint64_t seed = 0;  ///< each stage draws from its own stream of it
  /// The object that the detector has to take first: another one ends the attempt. Without it the
  /// attempt is at whatever the detector takes, and goes by the hand's aperture in place of truth.
  std::optional<int> target;
  const Sensed* sensed = nullptr;  ///< an earlier look at the same world; null: looks itself
  std::function<void(const Sensed&)> on_sensed;  ///< is shown all that was sensed before the grasp
  /// Where the arm was left by it; home if not given.
  std::optional<Eigen::VectorXd> q_start;
  const Detector* detector = nullptr;  ///< in place of the cell's; may be null
  Turn turn;                           ///< which object is taken first
  /// Puts the grasps of the first object into the order in which they are offered to the mover; may
  /// be empty.
  std::function<void(grasp::Detection&)> prefer;
  std::optional<sim::UserOptions> user;  ///< takes what is carried; none: it is put down
  sim::ExecutionObserver observer;       ///< has the moment "start", too, before the look
};

/// One attempt at the topmost object: how far it came, and what each stage left.
struct Attempt {
  Outcome outcome = Outcome::kCrashed;
  std::string stage;  ///< that it ended in
  std::string detail;
  std::size_t scan_points = 0;
  std::vector<LookRecord> looks;  ///< from the wrist
  Detected detected;
  std::optional<int> target;                  ///< truth: the object that it was at
  bool accepted = false;                      ///< detected, with a grasp that is free
  int plans = 0;                              ///< grasps that were offered to the mover
  int approaches = 0;                         ///< all but the last met something and went back
  bool blind = false;                         ///< Move
  bool brushes = false;                       ///< Move
  std::optional<grasp::DetectedGrasp> grasp;  ///< that was executed
  /// Positions in the detection's grasps of those that were executed, in turn: all but the last met
  /// something and went back.
  std::vector<std::size_t> executed;
  std::optional<sim::ExecutionLog> log;
  OthersVerdict others;
  std::vector<std::pair<std::string, double>> seconds;  ///< by stage
};

/// Stages 2 to 6: looks, detects, plans, executes, judges. What it may run into is an outcome.
Attempt RunAttempt(const Cell& cell, sim::World& world, const AttemptOptions& options);

/// scan_points, object_points, segments, objects, candidates, free_candidates, plans, approaches,
/// blind, grasp_type, detected, log (what the simulation measured, with the audit).
nlohmann::ordered_json JsonOf(const Attempt& attempt);

}  // namespace rangegrasp::trial
