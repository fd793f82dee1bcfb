#pragma once

#include <string>

#include "tasks/grasping/attempt.h"

namespace rangegrasp::tasks::grasping {

struct DetectorCheck {
  std::string text;  ///< what was understood of each answer; ends with an end of line
  bool failed = false;
};

/// Asks the cell's detector, which is another program, about the first arrangement of up to three
/// objects, says what of its answers was understood, and the first thing that is wrong with its
/// cure; then whether a sandbox can be made here, whether the detector works in it, and whether it
/// gives the same answer to the same question.
DetectorCheck CheckDetector(const Cell& cell);

}  // namespace rangegrasp::tasks::grasping
