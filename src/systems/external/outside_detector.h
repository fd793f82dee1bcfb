#pragma once

#include <memory>

#include "external/outside_options.h"
#include "grasp/detector.h"

namespace rangegrasp::external {

/// A detector that is another program (docs/bring-your-own-detector.md). Each question starts it in
/// a new folder of its own and ends it after its answer: nothing of one trial is left for the next,
/// so that results do not depend on the number of workers, and what breaks costs one trial.
/// The arguments but `outside` must outlive it.
/// @param observer  sees the answer as a scene, with the table and what lies above it; may be empty
std::unique_ptr<grasp::Detector> MakeOutsideDetector(const OutsideOptions& outside,
                                                     const grasp::DetectorOptions& options,
                                                     const robot::Robot& robot,
                                                     grasp::SceneObserver observer = {});

}  // namespace rangegrasp::external
