#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "geometry/plane.h"
#include "grasp/detector.h"
#include "sim/execute.h"
#include "sim/world.h"
#include "trial/cell.h"

namespace rangegrasp::trial {

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
  kDetectorFailed,
  kCrashed,
};
constexpr std::array<std::string_view, 11> WordsOf(Outcome) {
  return {"delivered",       "not_segmented",   "wrong_target", "no_grasp",
          "no_path",         "not_lifted",      "dropped",      "misplaced",
          "invalid_physics", "detector_failed", "crashed"};
}

/// What the judge makes of a detection, from the labels that it alone knows.
struct DetectionVerdict {
  /// The first object holds more than half of the target's samples in the raw observation that lie
  /// clear of the table; of an object that is not meant whole one sample is enough.
  bool segmented = false;
  bool right_target = false;  ///< more than half of the first object's samples are the target's
  double share_of_object = 0.0;
  double share_of_target = 0.0;
};
/// What the judge knows of a trial.
struct TargetTruth {
  std::uint32_t label = 0;   ///< of the target, in the truth of each view
  geometry::Plane table_W;   ///< normal up
  double clearance_m = 0.0;  ///< lower samples do not count: the preselection's distance
};
DetectionVerdict JudgeDetection(const grasp::Detection& detection, const Sensed& sensed,
                                const TargetTruth& target);

/// How many of the samples bear each object's label, by object; -1: the scene's.
std::map<int, int> ObjectVotes(const std::vector<geometry::SampleId>& samples,
                               const Sensed& sensed);

/// The object that most samples of a detection's first one show; where they show none (a part of
/// the scene was taken for an object) the nearest one. nullopt if the world holds no object.
std::optional<int> AimedAt(const grasp::Detection& detection, const Sensed& sensed,
                           const sim::World& world);

/// Whether an object rests at the delivery place, as Delivered asks for.
bool IsAtDelivery(const sim::World& world, int object);

/// delivered, not_lifted, dropped, misplaced or invalid_physics (docs/architecture.md,
/// definitions).
Outcome JudgeExecution(const sim::ExecutionLog& log);

/// What became of the other objects.
struct OthersVerdict {
  int moved = 0;       ///< further than 5 mm, from before the grasp to its end
  int left_table = 0;  ///< no longer over the table
  int brought = 0;     ///< moved, and at the delivery place
};
/// Centers of mass of all objects.
std::vector<Eigen::Vector3d> CentersOf(const sim::World& world);
OthersVerdict JudgeOthers(const std::vector<Eigen::Vector3d>& before_W, const sim::World& world,
                          int target);

}  // namespace rangegrasp::trial
