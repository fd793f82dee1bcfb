#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "recognition/recognize.h"
#include "recognition/task/recognition_options.h"
#include "sim/world.h"
#include "trial/sensor.h"

namespace rangegrasp::recognition_task {

/// What became of an object that is to be found.
enum class Outcome { kFound, kWrongPose, kWrongObject, kUnknown };
constexpr std::array<std::string_view, 4> WordsOf(Outcome) {
  return {"found", "wrong_pose", "wrong_object", "unknown"};
}

/// What was found beside the truth, which the judge alone reads.
struct JudgedFind {
  const recognition::FoundObject* found = nullptr;
  int truth = -1;  ///< the object that most of its samples are of; -1: the scene
  bool named_right = false;
  recognition::PoseDifference off;  ///< where it is named right
};

struct Judgement {
  Outcome outcome = Outcome::kUnknown;  ///< of the target
  std::vector<JudgedFind> finds;        ///< in the order found
  const JudgedFind* OfTarget(int target) const;
};

/// Judges what was found. Of the target: what its samples were taken for; kUnknown where no find is
/// of it.
Judgement Judge(const std::vector<recognition::FoundObject>& found,
                const recognition::Library& library, const trial::Sensed& sensed,
                const sim::World& world, int target, const Options& options);

}  // namespace rangegrasp::recognition_task
