#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/frames.h"
#include "base/units.h"
#include "geometry/observation.h"
#include "grasp/detector.h"
#include "sim/world.h"
#include "trial/trial.h"

namespace rangegrasp::clearing {

/// When the table is scanned again (section 5.1, fig. 5.2).
enum class Rescan {
  kEach,          ///< after each grasp
  kAfterFailure,  ///< what was taken is left out of the last scan; a failed grasp needs a new one
};
constexpr std::array<std::string_view, 2> WordsOf(Rescan) { return {"each", "after_failure"}; }

/// When a failed object is tried again.
enum class Retry {
  kAtOnce,
  kAfterOthers,  ///< those with fewer failed tries first: what was in the way may be gone by then
};
constexpr std::array<std::string_view, 2> WordsOf(Retry) { return {"at_once", "after_others"}; }

/// How a program that does not know the truth goes on after a grasp (the keys' texts in
/// task/clearing_task.cpp).
struct ClearingOptions {
  int runs = 100;
  Rescan rescan = Rescan::kEach;
  Retry retry = Retry::kAfterOthers;
  int tries_per_object = 3;
  int max_grasps = 0;
  int idle_scans = 2;              ///< noise may have hidden a grasp
  double same_object_share = 0.5;  ///< the sensor does not move between scans
  /// Half of a fingertip's width, and what the hand's own give evens out.
  double other_grasp_m = 0.010;
  double other_grasp_rad = 15.0 * base::kDeg;
};

using Samples = std::vector<geometry::SampleId>;

/// Samples that two objects of scans from the same place have in common, of those that either has.
double SharedSamples(Samples a, Samples b);

/// Why an object is passed over.
enum class Passed {
  kNotYet,       ///< it is not
  kNoGrasp,      ///< none is free, as the scene stands
  kNoPath,       ///< none is reached, as the scene stands
  kTriesUsedUp,  ///< for good
};
constexpr std::array<std::string_view, 4> WordsOf(Passed) {
  return {"not_tried", "no_grasp", "no_path", "tries_used_up"};
}

/// What the program remembers of objects that it could not take. It knows an object again by its
/// samples alone: one that a grasp has moved is a new one to it.
class TriedObjects {
 public:
  explicit TriedObjects(const ClearingOptions& options) : options_(&options) {}

  Passed StateOf(const Samples& object) const;
  bool MayBeTaken(const Samples& object) const { return StateOf(object) == Passed::kNotYet; }
  /// nullopt if it may not be taken; else 0, or its failed tries where others come before it.
  std::optional<int> TurnOf(const Samples& object) const;
  int TriesAt(const Samples& object) const;

  /// No grasp could be executed: it is passed over until the scene changes.
  void PassOver(const Samples& object, Passed why);
  /// A grasp with the hand there was executed and failed.
  void Failed(const Samples& object, const base::Pose& X_CH);
  /// It is gone; another one may be seen in its place.
  void Taken(const Samples& object);
  /// What could not be grasped may be free now. Used-up tries stay so.
  void SceneChanged();

  /// Puts the first object's grasps that are like one that has failed at it behind the others.
  void PutFailedLast(grasp::Detection& detection) const;

 private:
  struct Entry {
    Samples samples;
    int tries = 0;
    Passed passed = Passed::kNotYet;
    std::vector<base::Pose> failed_X_CH;
  };
  const Entry* Find(const Samples& object) const;
  Entry& FindOrAdd(const Samples& object);
  bool LikeFailed(const Entry& entry, const base::Pose& X_CH) const;

  const ClearingOptions* options_;
  std::vector<Entry> entries_;
};

/// Why a run ended.
enum class Stop {
  kNothingPerceived,  ///< the program takes the table for empty
  kNothingGraspable,  ///< of all that it sees none has a free grasp
  kNoPath,            ///< some have one, none is reached
  kTriesUsedUp,       ///< what is left has been tried as often as allowed
  kMaxGrasps,
  kEmpty,           ///< truth: no object is left; the program still sees something
  kBrokenPhysics,   ///< the engine lost the state of the world
  kDetectorFailed,  ///< one that is another program
  kCrashed,         ///< an attempt did
};
constexpr std::array<std::string_view, 9> WordsOf(Stop) {
  return {"nothing_perceived", "nothing_graspable", "no_path",
          "tries_used_up",     "max_grasps",        "empty",
          "broken_physics",    "detector_failed",   "crashed"};
}

/// Where an object is at the end, by truth.
enum class Fate {
  kDelivered,  ///< a grasp at it was judged so
  kBrought,    ///< it came to the delivery place otherwise: beside another one, or not validly
  kLeft,
};
constexpr std::array<std::string_view, 3> WordsOf(Fate) { return {"delivered", "brought", "left"}; }

struct ObjectEnd {
  std::string object;
  Fate fate = Fate::kLeft;
  int grasps = 0;  ///< in which the hand had it, or nothing and was at it
  /// Why it was left: off_table, out_of_workspace, not_perceived (it is not the main part of any
  /// object of the last scan), or what the program has it passed over for (Passed). Of what was
  /// brought: the outcome of the grasp. Empty if delivered.
  std::string why;
};

/// One attempt of a run.
struct Step {
  trial::Attempt attempt;
  int scan = 0;                 ///< it was made on, from 1
  int try_number = 0;           ///< at that object, as the program counts, from 1
  bool felt = false;            ///< the hand's aperture showed until the end that it held something
  std::vector<int> taken_away;  ///< objects that it left at the delivery place
};

/// A run, from its arrangement to its end.
struct Clearing {
  Stop stop = Stop::kNothingPerceived;
  std::string detail;
  int scans = 0;
  std::size_t perceived = 0;  ///< objects of the last scan
  double homing_s = 0.0;      ///< ways home, by the arm's limits; not simulated
  double scan_s = 0.0;        ///< computing time of all scans
  std::vector<Step> steps;
  std::vector<ObjectEnd> objects;

  int Grasps() const;          ///< attempts that were executed
  int Count(Fate fate) const;  ///< objects
};

/// What a viewer sees of a run.
struct ClearingObserver {
  const trial::Detector* detector = nullptr;  ///< in place of the cell's; may be null
  sim::ExecutionObserver execution;
  std::function<void(int attempt)> on_attempt;  ///< before each, from 1; may be empty
  std::function<void(sim::World&)> on_end;      ///< may be empty
};

/// Clears the world (section 5.1, fig. 5.2): scan, take the topmost object, deliver it, and again,
/// until nothing is perceived or nothing can be done.
///
/// The program knows no truth. It feels by the aperture of the closed hand that a grasp has failed
/// and tries again, with another grasp where there is one. An object without a free grasp, or that
/// the arm does not reach, is passed over until something else has been taken.
///
/// Between two attempts what lies at the delivery place is taken away, and the arm is put back at
/// home (trial::GoHome). Friction should be drawn before.
/// @param world  settled, the arm at home; what is left stays in it
/// @param seed  each scan and each attempt draws from its own stream of it
Clearing ClearTable(const trial::Cell& cell, const ClearingOptions& options, int max_grasps,
                    sim::World& world, std::uint64_t seed, const ClearingObserver& observer = {});

}  // namespace rangegrasp::clearing
