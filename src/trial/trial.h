#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "base/units.h"
#include "base/yaml_map.h"
#include "experiment/record.h"
#include "sim/execute.h"
#include "trial/cell.h"
#include "trial/judge.h"

namespace rangegrasp::trial {

/// The stream that a stage draws from.
base::Rng StageStream(std::uint64_t seed, std::string_view stage);

/// Stage 2, at a settled world. Draws from the seed's stream "scan".
Sensed Look(const Cell& cell, const sim::World& world, std::uint64_t seed);

/// One further look, from the wrist (Registry: FurtherLooks).
struct LookRecord {
  double gain_m3 = 0.0;     ///< new space that it was expected to see
  double unseen_m3 = 0.0;   ///< of all that was not seen
  double way_s = 0.0;       ///< of the arm
  bool arrived = false;     ///< and did look
  bool refined = false;     ///< its pose was corrected by what it and the views before see alike
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

/// How an attempt is made, and who looks on. Functions and pointers may be empty.
struct AttemptOptions {
  std::uint64_t seed = 0;  ///< each stage draws from its own stream of it
  /// The object that the detector has to take first: another one ends the attempt. Without it the
  /// attempt is at whatever the detector takes, and goes by the hand's aperture in place of truth.
  std::optional<int> target = {};
  /// Goes on where the first object only holds something of the target (TextVerdict).
  bool by_text = false;
  const Sensed* sensed = nullptr;  ///< an earlier look at the same world; null: looks itself
  std::function<void(const Sensed&)> on_sensed = {};  ///< is shown what was sensed
  std::optional<Eigen::VectorXd> q_start = {};        ///< where the arm stands; absent: home
  const Detector* detector = nullptr;                 ///< in place of the cell's
  Turn turn = {};                                     ///< which object is taken first
  /// Puts the grasps of the first object into the order in which they are offered to the mover.
  std::function<void(grasp::Detection&)> prefer = {};
  std::optional<sim::UserOptions> user = {};  ///< takes what is carried; absent: it is put down
  sim::ExecutionObserver observer = {};       ///< has the moment "start", too, before the look
};

/// The verdict of the dissertation's words: "If objects cannot be separated because they are
/// stacked on top of each other they are considered as one object. A grasp will disambiguate the
/// situation" (chapter 5); detection is lower in a box "because of possible collisions of the hand
/// with the box" (section 5.3). So the first object need not be the target alone.
struct TextVerdict {
  /// A collision-free grasp of the first object, whose samples hold at least one of the target.
  bool detected = false;
  Outcome outcome = Outcome::kCrashed;  ///< of executing that grasp; delivered: the target was
  std::string detail = {};
};

/// One attempt at the topmost object: how far it came, and what each stage left. With by_text, what
/// happened after an outcome of not_segmented or wrong_target is that of the text's verdict.
struct Attempt {
  Outcome outcome = Outcome::kCrashed;
  std::string stage = {};  ///< that it ended in
  std::string detail = {};
  TextVerdict text = {};
  std::size_t scan_points = 0;
  std::vector<LookRecord> looks = {};  ///< from the wrist
  Detected detected = {};
  std::optional<int> target = {};                  ///< truth: the object that it was at
  bool accepted = false;                           ///< detected, with a grasp that is free
  int plans = 0;                                   ///< grasps that were offered to the mover
  int approaches = 0;                              ///< all but the last met something and went back
  bool blind = false;                              ///< grasp::Move
  bool brushes = false;                            ///< grasp::Move
  std::optional<grasp::DetectedGrasp> grasp = {};  ///< that was executed last
  std::vector<std::size_t> executed =
      {};  ///< one for each approach: positions in the detection's grasps
  std::optional<sim::ExecutionLog> log = {};
  OthersVerdict others = {};
  std::vector<std::pair<std::string, double>> seconds = {};  ///< by stage
};

/// Stages 2 to 6: looks, detects, plans, executes, judges. What it may run into is an outcome.
Attempt RunAttempt(const Cell& cell, sim::World& world, const AttemptOptions& options);

/// The part of a trial's data (RunTrial) from scan_points on.
nlohmann::ordered_json JsonOf(const Attempt& attempt);

/// One attempt on one object. Each stage draws from its own stream of the trial's seed.
struct TrialSpec {
  std::string object;
  int index = 0;           ///< from 0
  std::uint64_t seed = 0;  ///< TrialSeed
};
/// As the engine knows it: its id is "<object>-<index, 4 digits>", its group the object.
experiment::Case CaseOf(const TrialSpec& spec);
/// @throws base::InputError if the case's parameters are no trial's.
TrialSpec SpecOf(const experiment::Case& which);
/// Derived from (experiment seed, object, index) alone.
std::uint64_t TrialSeed(std::uint64_t experiment_seed, const std::string& object, int index);

/// Puts what every result of the cell depends on into the stamp's identity: the hash of its models
/// and the engine's version.
void AddModelsTo(const Options& options, experiment::Stamp& stamp);

/// Puts the titles of the experiment's objects into the stamp's data (experiment::TitleOf).
void AddTitles(const Options& options, experiment::Stamp& stamp);

/// Of a case for which no arrangement came about.
experiment::Result NoArrangement(const Redraws& redraws);

/// Stage 1 of a trial, as RunTrial goes through it.
std::optional<Arrangement> ArrangeTrial(const Cell& cell, const TrialSpec& spec);
std::optional<Arrangement> ArrangeTrial(const Cell& cell, const TrialSpec& spec, Redraws& redraws);

/// One trial from arrangement to judgement (docs/architecture.md). What a trial may run into is an
/// outcome. The result's data: pose_class, friction (static, glove on target), redraws,
/// redraw_reasons (how many of each), scene_objects, touching (objects that the target touches),
/// scan_points, object_points, segments, objects, candidates, free_candidates, plans, approaches,
/// blind, brushes, grasp_type, detected, text (detected, outcome, detail; TextVerdict),
/// others_moved (by more than 5 mm), others_left_table, others_brought (to the delivery place), log
/// (what the simulation measured, with the audit).
/// @param detector  in place of the cell's, so that a viewer can look on; may be null
/// @param seen  receives what each stage left; may be null
experiment::Result RunTrial(const Cell& cell, const TrialSpec& spec,
                            const Detector* detector = nullptr,
                            const sim::ExecutionObserver& observer = {}, Attempt* seen = nullptr);

/// Puts the arm back at home between two attempts, and lets the world come to rest. The way is
/// timed, not simulated.
/// @return seconds that the way takes by the arm's limits
double GoHome(const Cell& cell, sim::World& world);

/// Whether the engine still knows where everything is.
bool IsFinite(const sim::World& world);

/// The outcome of a run whose object a person has got.
inline constexpr const char* kHandedOver = "handed_over";

/// A person who draws the object out of the hand (section 4.3).
struct HandOverOptions {
  sim::UserOptions user;
  /// The pull's direction is drawn within this of the one that objects leave the open hand by:
  /// people stand somewhere. Larger: the object is drawn through fingers.
  double pull_spread_rad = base::Deg(30.0);
};

/// Reads the keys of the mapping `user`.
/// @throws base::InputError
void ReadUser(base::YamlMap map, HandOverOptions& options);

/// The person of one run.
/// @param out_H  unit: out of the open hand
sim::UserOptions UserFor(const HandOverOptions& options, const Eigen::Vector3d& out_H,
                         base::Rng& rng);

/// That of an attempt with the robot's hand, drawn from the stream "user" of the attempt's seed.
sim::UserOptions UserOf(const HandOverOptions& options, const robot::Robot& robot,
                        std::uint64_t seed);

/// How an attempt that ends with a person ended: its own word up to the carry; then handed_over,
/// felt_early (the arm took its own motion for a pull), not_felt, not_taken.
std::string HandOverOutcome(const Attempt& attempt);

}  // namespace rangegrasp::trial
