#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/frames.h"
#include "geometry/observation.h"
#include "grasp/detector.h"
#include "sim/world.h"
#include "trial/recorder.h"
#include "trial/trial.h"

namespace rangegrasp::clearing {

/// Rules of a program without ground truth for the steps after a grasp. The texts of the keys
/// (task/clearing_task.cpp) describe the fields.
struct ClearingOptions {
  int runs = 100;
  int tries_per_object = 3;
  int max_grasps = 0;
};

using Samples = std::vector<geometry::SampleId>;

/// Intersection over union of the samples of two objects in scans from the same viewpoint.
double SharedSamples(Samples a, Samples b);

/// Why an object is passed over.
enum class Passed {
  kNotYet,       ///< it is not passed over
  kNoGrasp,      ///< no collision-free grasp in the current scene
  kNoPath,       ///< no reachable grasp in the current scene
  kTriesUsedUp,  ///< permanently
};
constexpr std::array<std::string_view, 4> WordsOf(Passed) {
  return {"not_tried", "no_grasp", "no_path", "tries_used_up"};
}

/// The program's memory of objects that it could not grasp. It recognizes an object only by its
/// samples, so an object that was moved by a grasp is a new one.
class TriedObjects {
 public:
  explicit TriedObjects(int tries_per_object) : tries_per_object_(tries_per_object) {}

  Passed StateOf(const Samples& object) const;
  /// nullopt if it may not be taken; else its number of failed tries: obstacles may be gone after
  /// the objects with fewer.
  std::optional<int> TurnOf(const Samples& object) const;
  int TriesAt(const Samples& object) const;

  /// Passes the object over until the scene changes, since no grasp could be executed.
  void PassOver(const Samples& object, Passed why);
  /// A grasp with this hand pose was executed and failed.
  void Failed(const Samples& object, const base::Pose& X_CH);
  /// The object is gone. Another one may be seen in its place.
  void Taken(const Samples& object);
  /// Passed-over objects may be graspable now, except those without tries left.
  void SceneChanged();

  /// Moves the first object's grasps that are similar to a failed one behind the others.
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

  int tries_per_object_;
  std::vector<Entry> entries_;
};

/// Why a run ended.
enum class Stop {
  kNothingPerceived,  ///< the program perceives an empty table
  kNothingGraspable,  ///< no perceived object has a collision-free grasp
  kNoPath,            ///< some objects have a grasp, but the arm reaches none
  kTriesUsedUp,       ///< an object that is left has been tried as often as allowed
  kMaxGrasps,
  kEmpty,           ///< truth: no object is left, but the program still perceives something
  kBrokenPhysics,   ///< the world's state is no longer finite
  kDetectorFailed,  ///< an external detector failed
  kCrashed,         ///< an attempt crashed
};
constexpr std::array<std::string_view, 9> WordsOf(Stop) {
  return {"nothing_perceived", "nothing_graspable", "no_path",
          "tries_used_up",     "max_grasps",        "empty",
          "broken_physics",    "detector_failed",   "crashed"};
}

/// Where an object is at the end, by ground truth.
enum class Fate {
  kDelivered,  ///< the outcome of a grasp of this object was `delivered`
  kBrought,    ///< it reached the delivery place with another object or with another outcome
  kLeft,
};
constexpr std::array<std::string_view, 3> WordsOf(Fate) { return {"delivered", "brought", "left"}; }

struct ObjectEnd {
  std::string object;
  Fate fate = Fate::kLeft;
  int grasps = 0;  ///< grasps that held it, or that were aimed at it and held nothing
  /// Why it was left: off_table, out_of_workspace, not_perceived (it is not the main part of any
  /// object of the last scan), or why the program passes it over (Passed). For an object that was
  /// brought: the outcome of the grasp, or beside_another. Empty if delivered.
  std::string why;
};

/// One attempt of a run.
struct Step {
  trial::Attempt attempt;
  int scan = 0;                 ///< number of the scan that it used, from 1
  int try_number = 0;           ///< the program's count of tries at that object, from 1
  bool felt = false;            ///< by its aperture, the hand held something until the end
  std::vector<int> taken_away;  ///< objects that were removed from the delivery place after it
};

/// A run, from its arrangement to its end.
struct Clearing {
  Stop stop = Stop::kNothingPerceived;
  std::string detail;
  int scans = 0;
  std::size_t perceived = 0;  ///< number of objects in the last scan
  double homing_s = 0.0;      ///< time of the motions home, by the arm's limits; not simulated
  double scan_s = 0.0;        ///< computing time of all scans
  std::vector<Step> steps;
  std::vector<ObjectEnd> objects;

  int Grasps() const;          ///< number of executed attempts
  int Count(Fate fate) const;  ///< number of objects
};

/// Clears the world (section 5.1, fig. 5.2): scans, grasps the topmost object, delivers it, and
/// repeats this until nothing is perceived or nothing can be done.
///
/// The program has no ground truth. It detects a failed grasp by the aperture of the closed hand
/// and tries again, with another grasp if there is one. An object without a collision-free grasp,
/// or out of the arm's reach, is passed over until the scene changes.
///
/// Between two attempts, objects at the delivery place are removed, and the arm is put back at home
/// (trial::GoHome). Friction should be drawn before.
/// @param world  settled, the arm at home; the remaining objects stay in it
/// @param seed  each scan and each attempt draws from its own stream of this seed
/// @param recorder  has the detector, and takes pictures of each attempt and at the end
Clearing ClearTable(const trial::Cell& cell, const ClearingOptions& options, sim::World& world,
                    std::uint64_t seed, trial::Recorder& recorder);

}  // namespace rangegrasp::clearing
