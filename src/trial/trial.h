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
#include "experiment/task.h"
#include "sim/execute.h"
#include "trial/cell.h"
#include "trial/judge.h"

namespace rangegrasp::trial {

/// The random stream of a stage.
base::Rng StageStream(std::uint64_t seed, std::string_view stage);

/// Stage 2: scans a settled world. Draws from the seed's stream "scan".
Sensed Look(const Cell& cell, const sim::World& world, std::uint64_t seed);

/// One additional scan from the wrist (registry.h: FurtherLooks).
struct LookRecord {
  double gain_m3 = 0.0;     ///< unseen volume that the scan was expected to show
  double unseen_m3 = 0.0;   ///< total unseen volume before the scan
  double way_s = 0.0;       ///< duration of the arm's motion
  bool arrived = false;     ///< the arm arrived and the sensor scanned
  bool refined = false;     ///< its pose was corrected by registration with the earlier views
  double deviations = 0.0;  ///< size of the correction, in standard deviations of the pose error
  double sigma_m = 0.0;
  std::size_t pairs = 0;
};

/// Result of all scans of a trial: the observation and the arm's final joint positions.
struct LookedAround {
  Sensed sensed;
  Eigen::VectorXd q;
  std::vector<LookRecord> looks;  ///< scans from the wrist
};

/// A detector that returns a detection made beforehand.
class FixedDetector : public Detector {
 public:
  explicit FixedDetector(Detected detected) : detected_(std::move(detected)) {}
  Detected Detect(const geometry::Observation&, base::Rng&, const Turn&) const override {
    return detected_;
  }

 private:
  Detected detected_;
};

/// Options and observers of an attempt. Functions and pointers may be empty.
struct AttemptOptions {
  std::uint64_t seed = 0;  ///< each stage draws from its own stream of this seed
  /// The object that the detector must put first; any other first object ends the attempt. Without
  /// a target, the attempt grasps the detector's first object and uses the hand's aperture instead
  /// of ground truth.
  std::optional<int> target = {};
  /// Continues if the first object contains only a part of the target (TextVerdict).
  bool by_text = false;
  const Sensed* sensed = nullptr;  ///< an earlier scan of the same world; null: takes its own
  std::function<void(const Sensed&)> on_sensed = {};  ///< called with the result of the scan
  std::optional<Eigen::VectorXd> q_start = {};        ///< the arm's position; absent: home
  const Detector* detector = nullptr;                 ///< replaces the cell's
  Turn turn = {};                                     ///< which object is grasped first
  /// Sorts the grasps of the first object into the order in which the mover tries them.
  std::function<void(grasp::Detection&)> prefer = {};
  std::optional<sim::UserOptions> user = {};  ///< person who takes the object; absent: put it down
  sim::ExecutionObserver observer = {};       ///< also gets the moment "start", before the scan
};

/// The verdict by the dissertation's wording: "If objects cannot be separated because they are
/// stacked on top of each other they are considered as one object. A grasp will disambiguate the
/// situation" (chapter 5); detection is lower in a box "because of possible collisions of the hand
/// with the box" (section 5.3). The first object may therefore contain other objects too.
struct TextVerdict {
  /// The first object has a collision-free grasp and contains at least one sample of the target.
  bool detected = false;
  Outcome outcome = Outcome::kCrashed;  ///< of executing that grasp; delivered means the target
  std::string detail = {};
};

/// One attempt at the topmost object: its outcome and the results of each stage. With by_text, the
/// results after an outcome of not_segmented or wrong_target belong to the text's verdict.
struct Attempt {
  Outcome outcome = Outcome::kCrashed;
  std::string stage = {};  ///< stage in which it ended
  std::string detail = {};
  TextVerdict text = {};
  std::size_t scan_points = 0;
  std::vector<LookRecord> looks = {};  ///< scans from the wrist
  Detected detected = {};
  std::optional<int> target = {};            ///< ground truth: the object of the attempt
  bool accepted = false;                     ///< detected, with a collision-free grasp
  int plans = 0;                             ///< grasps that the mover tried to plan
  bool blind = false;                        ///< grasp::Move
  bool brushes = false;                      ///< grasp::Move
  std::optional<std::size_t> executed = {};  ///< position in the detection's grasps
  std::optional<sim::ExecutionLog> log = {};
  OthersVerdict others = {};
  std::vector<std::pair<std::string, double>> seconds = {};  ///< by stage

  /// The grasp that was executed; null if none was.
  const grasp::DetectedGrasp* Grasp() const {
    return executed ? &detected.detection.grasps[*executed] : nullptr;
  }
};

/// Stages 2 to 6: scans, detects, plans, executes, judges. Failures are outcomes, not exceptions.
Attempt RunAttempt(const Cell& cell, sim::World& world, const AttemptOptions& options);

/// The part of a trial's data (RunTrial) from scan_points on.
nlohmann::ordered_json JsonOf(const Attempt& attempt);

/// One attempt on one object. Each stage draws from its own stream of the trial's seed.
struct TrialSpec {
  std::string object;
  int index = 0;           ///< from 0
  std::uint64_t seed = 0;  ///< TrialSeed
};
/// The trial as a case of the experiment engine. Its id is "<object>-<index, 4 digits>", and its
/// group is the object.
experiment::Case CaseOf(const TrialSpec& spec);
/// @throws base::InputError if the case's parameters are not those of a trial.
TrialSpec SpecOf(const experiment::Case& which);
/// Derived from (experiment seed, object, index) alone.
std::uint64_t TrialSeed(std::uint64_t experiment_seed, const std::string& object, int index);

/// Adds the dependencies of all results to the stamp's identity: the hash of the cell's models and
/// the engine's version.
void AddModelsTo(const Options& options, experiment::Stamp& stamp);

/// Adds the titles of the experiment's objects to the stamp's data (experiment::TitleOf).
void AddTitles(const Options& options, experiment::Stamp& stamp);

/// Result of a case for which no arrangement was found.
experiment::Result NoArrangement(const Redraws& redraws);

/// Stage 1 of a trial, as in RunTrial.
std::optional<Arrangement> ArrangeTrial(const Cell& cell, const TrialSpec& spec);
std::optional<Arrangement> ArrangeTrial(const Cell& cell, const TrialSpec& spec, Redraws& redraws);

/// A task whose cases begin with an arranged scene in a work cell.
class SceneTask : public experiment::Task {
 public:
  virtual const Cell& cell() const = 0;
  /// The scene at the start of a case; its target is the case's object.
  virtual std::optional<Arrangement> Arrange(const experiment::Case& which,
                                             Redraws& redraws) const {
    return ArrangeTrial(cell(), SpecOf(which), redraws);
  }
};

/// Runs one trial from arrangement to judgment (docs/architecture.md). Failures are outcomes, not
/// exceptions. The result's data: pose_class, friction (static, glove on target), redraws,
/// redraw_reasons (count of each), scene_objects, touching (objects that the target touches),
/// scan_points, object_points, segments, objects, candidates, free_candidates, plans,
/// blind, brushes, grasp_type, detected, text (detected, outcome, detail; TextVerdict),
/// others_moved (by more than 5 mm), others_left_table, others_brought (to the delivery place), log
/// (the simulation's measurements, with the audit).
/// @param detector  replaces the cell's, so that a viewer can observe it; may be null
/// @param seen  receives the results of each stage; may be null
experiment::Result RunTrial(const Cell& cell, const TrialSpec& spec,
                            const Detector* detector = nullptr,
                            const sim::ExecutionObserver& observer = {}, Attempt* seen = nullptr);

/// Puts the arm back at home between two attempts, and lets the world come to rest. The motion is
/// timed, not simulated.
/// @return duration of the motion by the arm's limits [s]
double GoHome(const Cell& cell, sim::World& world);

/// Whether all positions of objects and arm are finite.
bool IsFinite(const sim::World& world);

/// "grasp: power, pads closing to 81 mm, pitch 8 deg, predicted probability of delivery 0.96";
/// empty if no grasp was executed.
/// @param attempt  JsonOf(Attempt)
/// @param name  of the grasp in the object's grasps.yaml; empty: a grasp that was planned
std::string GraspText(const nlohmann::ordered_json& attempt, const std::string& name = "");

/// The outcome of a run in which a person received the object.
inline constexpr const char* kHandedOver = "handed_over";

/// A person who pulls the object out of the hand (section 4.3).
struct HandOverOptions {
  sim::UserOptions user;
  /// Maximum angle between the random direction of the pull and the direction straight out of the
  /// open hand: people may stand anywhere. With larger angles the fingers are in the way.
  double pull_spread_rad = base::Deg(30.0);
};

/// Reads the keys of the mapping `user`.
/// @throws base::InputError
void ReadUser(base::YamlMap map, HandOverOptions& options);

/// Draws the person of one run.
/// @param out_H  unit vector out of the open hand
sim::UserOptions UserFor(const HandOverOptions& options, const Eigen::Vector3d& out_H,
                         base::Rng& rng);

/// The person of an attempt with the robot's hand, drawn from the stream "user" of its seed.
sim::UserOptions UserOf(const HandOverOptions& options, const robot::Robot& robot,
                        std::uint64_t seed);

/// The outcome of an attempt that ends with a person. Up to the carry it is the attempt's own;
/// then handed_over, felt_early (the arm mistook its own motion for a pull), not_felt, not_taken.
std::string HandOverOutcome(const Attempt& attempt);

}  // namespace rangegrasp::trial
