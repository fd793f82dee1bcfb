#pragma once

#include <array>
#include <cstdint>
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

/// The judge's verdict on a detection, from the labels, which only the judge knows.
struct DetectionVerdict {
  /// The first object contains more than half of the target's samples in the raw observation that
  /// are clear of the table. One sample is enough if the object is not whole (DetectedObject).
  bool segmented = false;
  bool right_target = false;  ///< more than half of the first object's samples are the target's
  double share_of_object = 0.0;
  double share_of_target = 0.0;
};
/// Ground truth of a trial.
struct TargetTruth {
  std::uint32_t label = 0;   ///< label of the target in the truth of each view
  geometry::Plane table_W;   ///< normal up
  double clearance_m = 0.0;  ///< lower samples are ignored: the preselection's distance
};
DetectionVerdict JudgeDetection(const grasp::Detection& detection, const Sensed& sensed,
                                const TargetTruth& target);

/// The object with most of the samples, from its label (sim::kContainerLabel: an open box is above
/// all objects); nullopt if the scene has most, or there is no sample.
std::optional<int> MainObject(const std::vector<geometry::SampleId>& samples, const Sensed& sensed);

/// The object to which most samples of the detection's first object belong. If they belong to none
/// (a part of the scene was detected as an object), the nearest object. nullopt without objects.
std::optional<int> AimedAt(const grasp::Detection& detection, const Sensed& sensed,
                           const sim::World& world);

/// Whether an object is at the delivery place, as required for the outcome `delivered`.
bool IsAtDelivery(const sim::World& world, int object);

/// delivered, not_lifted, dropped, misplaced or invalid_physics (docs/architecture.md,
/// definitions).
Outcome JudgeExecution(const sim::ExecutionLog& log);

/// Numbers of other objects that a grasp affected.
struct OthersVerdict {
  int moved = 0;       ///< moved by more than 5 mm between the start and the end of the grasp
  int left_table = 0;  ///< no longer over the table
  int brought = 0;     ///< moved, and now at the delivery place
};
/// Centers of mass of all objects.
std::vector<Eigen::Vector3d> CentersOf(const sim::World& world);
OthersVerdict JudgeOthers(const std::vector<Eigen::Vector3d>& before_W, const sim::World& world,
                          int target);

}  // namespace rangegrasp::trial
