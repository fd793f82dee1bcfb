#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "sensing/scan_truth.h"
#include "sim/execute.h"
#include "tasks/grasping/detector.h"

namespace rangegrasp::tasks::grasping {

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
};
constexpr std::array<std::string_view, 10> WordsOf(Outcome) {
  return {"delivered",  "not_segmented", "wrong_target", "no_grasp",        "no_path",
          "not_lifted", "dropped",       "misplaced",    "invalid_physics", "crashed"};
}

/// What the judge makes of a detection, from the labels that it alone knows.
struct DetectionVerdict {
  bool segmented = false;     ///< the first object holds more than half of the target's samples
  bool right_target = false;  ///< more than half of the first object's samples are the target's
  double share_of_object = 0.0;
  double share_of_target = 0.0;
};
/// @param truth         one a view
/// @param target_label  of the target in it
DetectionVerdict JudgeDetection(const Detected& detected,
                                const std::vector<sensing::ScanTruth>& truth,
                                std::uint32_t target_label);

/// What an execution is worth (docs/architecture.md, definitions): delivered, not_lifted, dropped,
/// misplaced or invalid_physics.
Outcome JudgeExecution(const sim::ExecutionLog& log);

}  // namespace rangegrasp::tasks::grasping
